#pragma once
#include <concepts>
#include <cstddef>
#include <memory>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/raster/shape_inputs.hpp>
#include <tapestry/raster/silhouette.hpp>
#include <tapestry/raster/silhouette_variable.hpp>
#include <utility>
#include <vector>

namespace tapestry::raster::detail {

template <std::floating_point T>
ArrayVariable<T, 2> record_coverage(std::shared_ptr<const geometry::Mesh> mesh,
                                    const geometry::Camera& camera, const geometry::Pose& at,
                                    Array<T, 2> coverage, const ArrayVariable<T, 2>& positions,
                                    const ArrayVariable<T, 1>& pose, std::size_t samples_per_axis,
                                    std::shared_ptr<const MeshEdges> edges) {
  auto pullback = [mesh = std::move(mesh), camera, at, samples_per_axis, edges = std::move(edges)](
                      const Array<T, 2>& adjoint, Array<T, 2>* positions_adjoint, Array<T, 1>* pose_adjoint) {
    std::vector<geometry::Vector3> moving(mesh->positions.size(), geometry::Vector3{0, 0, 0});
    silhouette_adjoint(*mesh, camera, adjoint, moving, samples_per_axis, edges);
    if (positions_adjoint != nullptr) add_positions(moving, *positions_adjoint);
    if (pose_adjoint != nullptr) add_pose(at, *mesh, moving, *pose_adjoint);
  };
  return record_array(std::move(coverage), std::move(pullback), positions, pose);
}

}  // namespace tapestry::raster::detail

namespace tapestry::raster {

template <std::floating_point T>
ArrayVariable<T, 2> silhouette(const geometry::Mesh& mesh, const geometry::Camera& camera, std::size_t height,
                               std::size_t width, const ArrayVariable<T, 2>& positions,
                               const ArrayVariable<T, 1>& pose, std::size_t samples_per_axis,
                               std::shared_ptr<const MeshEdges> edges) {
  const auto at = detail::pose_of("silhouette", pose);
  const auto seen_by = geometry::posed(camera, at);
  auto shape = std::make_shared<geometry::Mesh>();
  shape->positions = mesh.positions;
  shape->faces = mesh.faces;
  if (detail::is_given(positions)) geometry::set_positions(*shape, positions.value(), "silhouette");
  auto coverage = silhouette<T>(*shape, seen_by, height, width, samples_per_axis);
  return detail::record_coverage<T>(std::move(shape), seen_by, at, std::move(coverage), positions, pose,
                                    samples_per_axis, std::move(edges));
}

}  // namespace tapestry::raster

namespace tapestry::raster::detail {

template decltype(record_coverage<float>) record_coverage<float>;
template decltype(record_coverage<double>) record_coverage<double>;

}  // namespace tapestry::raster::detail

namespace tapestry::raster {

template ArrayVariable<float, 2> silhouette<float>(const geometry::Mesh& mesh, const geometry::Camera& camera,
                                                   std::size_t height, std::size_t width,
                                                   const ArrayVariable<float, 2>& positions,
                                                   const ArrayVariable<float, 1>& pose,
                                                   std::size_t samples_per_axis,
                                                   std::shared_ptr<const MeshEdges> edges);
template ArrayVariable<double, 2> silhouette<double>(
    const geometry::Mesh& mesh, const geometry::Camera& camera, std::size_t height, std::size_t width,
    const ArrayVariable<double, 2>& positions, const ArrayVariable<double, 1>& pose,
    std::size_t samples_per_axis, std::shared_ptr<const MeshEdges> edges);

}  // namespace tapestry::raster

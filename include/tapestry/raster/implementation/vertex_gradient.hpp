#pragma once
#include <tapestry/raster/render_variable.hpp>

namespace tapestry::raster {
namespace detail {
/// Colours of a silhouette: every face alike, so that only the mesh's outline counts.
struct OneColour {
  using Colour = std::array<double, 1>;
  [[nodiscard]] static constexpr Colour at(std::int32_t, const std::array<double, 3>&) { return {1}; }
  [[nodiscard]] static constexpr bool is_continuous() { return true; }
  [[nodiscard]] static constexpr bool agrees(const HalfEdge&, const HalfEdge&) { return true; }
};

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
}  // namespace detail

template <std::floating_point T>
void silhouette_adjoint(const geometry::Mesh& mesh, const geometry::Camera& camera,
                        const Array<T, 2>& silhouette_adjoint,
                        std::vector<geometry::Vector3>& positions_adjoint, std::size_t samples_per_axis,
                        const std::shared_ptr<const MeshEdges>& edges) {
  detail::require_view("silhouette_adjoint", camera, silhouette_adjoint.shape(0), silhouette_adjoint.shape(1),
                       samples_per_axis);
  require_corners("silhouette_adjoint", mesh);
  detail::require_positions_adjoint("silhouette_adjoint", mesh, positions_adjoint);
  const auto positions_view = positions_in_view(mesh, camera);
  FacesInView faces(mesh, positions_view, camera, silhouette_adjoint.shape(0), silhouette_adjoint.shape(1));
  detail::GrazingSpans none;  // all faces have one colour
  // Where faces cut through each other, they show the same.
  detail::add_boundaries(camera, detail::OneColour{}, silhouette_adjoint, samples_per_axis,
                         *detail::edges_of("silhouette_adjoint", mesh, edges), {}, false, faces, none,
                         positions_adjoint);
}

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
  if (detail::is_given(positions)) geometry::set_positions("silhouette", *shape, positions.value());
  auto coverage = silhouette<T>(*shape, seen_by, height, width, samples_per_axis);
  return detail::record_coverage<T>(std::move(shape), seen_by, at, std::move(coverage), positions, pose,
                                    samples_per_axis, std::move(edges));
}
}  // namespace tapestry::raster

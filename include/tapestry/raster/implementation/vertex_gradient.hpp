#pragma once
#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/geometry/camera.hpp>
#include <tapestry/raster/crossing_faces.hpp>
#include <tapestry/raster/face_field.hpp>
#include <tapestry/raster/faces_in_view.hpp>
#include <tapestry/raster/render_variable.hpp>
#include <tapestry/raster/silhouette.hpp>
#include <tapestry/raster/surface.hpp>
#include <tapestry/raster/vertex_gradient.hpp>
#include <tapestry/raster/vertex_gradient/edge_line.hpp>
#include <tapestry/raster/vertex_gradient/interior.hpp>
#include <tapestry/raster/vertex_gradient/intersections.hpp>
#include <tapestry/raster/vertex_gradient/outlines.hpp>
#include <tapestry/raster/vertex_gradient/pixel_map.hpp>
#include <tapestry/raster/visibility.hpp>
#include <utility>
#include <vector>

namespace tapestry::raster::detail {

/// Colours of a silhouette: every face alike, so that only the mesh's outline counts.
struct OneColour {
  using Colour = std::array<double, 1>;
  [[nodiscard]] static constexpr Colour at(std::int32_t, const std::array<double, 3>&) { return {1}; }
  [[nodiscard]] static constexpr bool is_continuous() { return true; }
  [[nodiscard]] static constexpr bool agrees(const HalfEdge&, const HalfEdge&) { return true; }
};

}  // namespace tapestry::raster::detail

namespace tapestry::raster {

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

template decltype(silhouette_adjoint<float>) silhouette_adjoint<float>;
template decltype(silhouette_adjoint<double>) silhouette_adjoint<double>;

}  // namespace tapestry::raster

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
  if (detail::is_given(positions)) geometry::set_positions("silhouette", *shape, positions.value());
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

namespace tapestry::raster::detail {

void require_positions_adjoint(const char* operation, const geometry::Mesh& mesh,
                               const std::vector<geometry::Vector3>& positions_adjoint) {
  if (positions_adjoint.size() != mesh.positions.size())
    throw ShapeError(std::string(operation) + ": positions_adjoint is [" +
                     std::to_string(positions_adjoint.size()) + "], expected [" +
                     std::to_string(mesh.positions.size()) + "], one entry a position");
}

std::shared_ptr<const MeshEdges> edges_of(const char* operation, const geometry::Mesh& mesh,
                                          std::shared_ptr<const MeshEdges> kept) {
  if (kept == nullptr) return std::make_shared<const MeshEdges>(mesh_edges(mesh));
  if (kept->welded.size() == mesh.positions.size() && kept->face_count == mesh.faces.size()) return kept;
  const auto size = [](std::size_t positions, std::size_t faces) {
    return std::to_string(positions) + " positions and " + std::to_string(faces) + " faces";
  };
  throw ShapeError(std::string(operation) + ": edges are those of a mesh of " +
                   size(kept->welded.size(), kept->face_count) + ", expected " +
                   size(mesh.positions.size(), mesh.faces.size()));
}

void leave_out_inner_sides(const MeshEdges& edges, const SeenFaces& seen,
                           const std::vector<geometry::Vector3>& positions_view,
                           const geometry::Camera& camera, FacesInView& faces) {
  if (!edges.is_closed) return;
  int shown = 0;
  for (const SeenFaces::Band& band : seen.bands())
    for (const std::int32_t face : band.faces()) {
      if (shown == 0) shown = faces.winding(face);
      if (shown == 0 || faces.winding(face) != shown) return;
    }
  if (shown == 0 ||
      std::any_of(positions_view.begin(), positions_view.end(),
                  [&](const geometry::Vector3& position) { return !(position[2] > camera.near); }))
    return;
  faces.leave_out(-shown);
}

}  // namespace tapestry::raster::detail

#pragma once
#include <tapestry/raster/render_variable.hpp>

namespace tapestry::raster::detail {

void require_positions_adjoint(const char* operation, const geometry::Mesh& mesh,
                               const std::vector<geometry::Vector3>& positions_adjoint) {
  if (positions_adjoint.size() != mesh.positions.size())
    throw ShapeError({operation, ": positions_adjoint is [", positions_adjoint.size(), "], expected [",
                      mesh.positions.size(), "], one entry a position"});
}

std::shared_ptr<const MeshEdges> edges_of(const char* operation, const geometry::Mesh& mesh,
                                          std::shared_ptr<const MeshEdges> kept) {
  if (kept == nullptr) return std::make_shared<const MeshEdges>(mesh_edges(mesh));
  if (kept->welded.size() == mesh.positions.size() && kept->face_count == mesh.faces.size()) return kept;
  const auto size = [](std::size_t positions, std::size_t faces) {
    return std::to_string(positions) + " positions and " + std::to_string(faces) + " faces";
  };
  throw ShapeError({operation, ": edges are those of a mesh of ", size(kept->welded.size(), kept->face_count),
                    ", expected ", size(mesh.positions.size(), mesh.faces.size())});
}

void leave_out_inner_sides(const MeshEdges& edges, const SeenFaces& seen,
                           const std::vector<geometry::Vector3>& positions_view,
                           const geometry::Camera& camera, FacesInView& faces) {
  if (!edges.is_closed) return;
  std::array<bool, 3> has{};  // faces of winding −1, 0 and 1
  seen.for_each_face(
      [&](std::int32_t face) { has[static_cast<std::size_t>(faces.winding(face) + 1)] = true; });
  if (has[1] || has[0] == has[2] ||
      std::any_of(positions_view.begin(), positions_view.end(),
                  [&](const geometry::Vector3& position) { return !(position[2] > camera.near); }))
    return;
  faces.leave_out(has[0] ? 1 : -1);
}

}  // namespace tapestry::raster::detail

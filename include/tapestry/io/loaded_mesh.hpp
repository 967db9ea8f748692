#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <tapestry/geometry/mesh.hpp>
#include <vector>

namespace tapestry::io {

/// A mesh and what was noticed while it was read.
struct LoadedMesh {
  geometry::Mesh mesh;
  std::vector<std::string> warnings;          ///< one line each, with file and line
  std::vector<std::string> material_files{};  ///< that were read beside the mesh, in order
  std::size_t polygon_count = 0;              ///< faces of more than three corners, split into triangles
  std::size_t crossing_count = 0;    ///< polygons that cross themselves, of which the triangles may be wrong
  std::size_t degenerate_count = 0;  ///< triangles without area; kept, since face lists count them
  std::size_t without_uv_count = 0;  ///< triangles with a corner that has no texture coordinates
  std::array<double, 3> lowest{};    ///< bounds of all vertices
  std::array<double, 3> highest{};
};

namespace detail {
/// Whether the corners lie on one line, or in one point.
inline bool is_degenerate(const geometry::Mesh& mesh, const geometry::Corners& face) {
  const auto corner = [&](std::size_t i) { return mesh.positions[static_cast<std::size_t>(face[i])]; };
  const auto origin = corner(0);
  std::array<double, 3> u = corner(1);
  std::array<double, 3> v = corner(2);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    u[axis] -= origin[axis];
    v[axis] -= origin[axis];
  }
  return u[1] * v[2] == u[2] * v[1] && u[2] * v[0] == u[0] * v[2] && u[0] * v[1] == u[1] * v[0];
}

/// Fills in the bounds and counts that follow from the mesh, which has a vertex; returns its largest extent.
inline double measure_mesh(LoadedMesh& loaded) {
  loaded.lowest = loaded.highest = loaded.mesh.positions.at(0);
  double extent = 0;
  for (const auto& position : loaded.mesh.positions) {
    for (std::size_t axis = 0; axis < 3; ++axis) {
      loaded.lowest[axis] = std::min(loaded.lowest[axis], position[axis]);
      loaded.highest[axis] = std::max(loaded.highest[axis], position[axis]);
      extent = std::max(extent, loaded.highest[axis] - loaded.lowest[axis]);
    }
  }
  for (const auto& face : loaded.mesh.faces)
    loaded.degenerate_count += is_degenerate(loaded.mesh, face) ? 1U : 0U;
  for (const auto& uvs : loaded.mesh.face_uvs)
    loaded.without_uv_count += uvs[0] < 0 || uvs[1] < 0 || uvs[2] < 0 ? 1U : 0U;
  return extent;
}
}  // namespace detail

}  // namespace tapestry::io

#pragma once
#include <tapestry/raster/painted_mesh.hpp>

namespace tapestry::test {
using UvTriangle = std::array<std::array<double, 2>, 3>;

/// Triangles of uv alone, each with uvs of its own; their places in space do not matter.
inline raster::PaintedMesh body_of(const std::vector<UvTriangle>& triangles, std::size_t height,
                                   std::size_t width, double u_extent = 1) {
  raster::PaintedMesh body;
  body.layout.height = height;
  body.layout.width = width;
  body.layout.u_extent = u_extent;
  body.mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}};
  for (const UvTriangle& triangle : triangles) {
    const auto first = static_cast<std::int32_t>(body.mesh.uvs.size());
    body.mesh.uvs.insert(body.mesh.uvs.end(), triangle.begin(), triangle.end());
    body.mesh.faces.push_back({0, 1, 2});
    body.mesh.face_uvs.push_back({first, first + 1, first + 2});
    body.painted.push_back(1);
  }
  return body;
}
}  // namespace tapestry::test

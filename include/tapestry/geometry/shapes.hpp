#pragma once
#include <tapestry/geometry/mesh.hpp>

namespace tapestry::geometry {
/// The square x, y in [−half, half] at z = 0, seen from above, as rows × columns cells of two triangles. Its
/// uv run from (0, 0) at the corner of least x and y to (1, 1).
///
/// \throws DomainError for more than 4096 rows or columns, or none, or unless half is positive
[[nodiscard]] inline Mesh plane(std::size_t rows, std::size_t columns, double half = 1) {
  if (rows == 0 || columns == 0 || rows > 4096 || columns > 4096)
    throw DomainError("plane: expected 1 to 4096 rows and columns");
  if (!(half > 0)) throw DomainError("plane: half its side must be positive");
  Mesh mesh;
  for (std::size_t row = 0; row <= rows; ++row)
    for (std::size_t column = 0; column <= columns; ++column) {
      const double u = static_cast<double>(column) / static_cast<double>(columns);
      const double v = static_cast<double>(row) / static_cast<double>(rows);
      mesh.positions.push_back({(2 * u - 1) * half, (2 * v - 1) * half, 0});
      mesh.uvs.push_back({u, v});
    }
  const auto step = static_cast<std::int32_t>(columns) + 1;
  for (std::int32_t row = 0; row < static_cast<std::int32_t>(rows); ++row)
    for (std::int32_t column = 0; column + 1 < step; ++column) {
      const std::int32_t low = row * step + column, high = low + step;
      mesh.faces.push_back({low, low + 1, high + 1});
      mesh.faces.push_back({low, high + 1, high});
    }
  mesh.face_uvs = mesh.faces;
  return mesh;
}

/// A sphere of nearly equal triangles: an icosahedron whose faces are cut into four, again and again, the new
/// corners moved out to the sphere. 20·4ⁿ faces, seen from outside, and 10·4ⁿ + 2 positions.
///
/// \param subdivisions  n, 0 to 8
/// \throws DomainError for more than 8, or unless radius is positive
[[nodiscard]] Mesh icosphere(std::size_t subdivisions, double radius = 1, const Vector3& centre = {0, 0, 0});
}  // namespace tapestry::geometry

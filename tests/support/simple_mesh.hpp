#pragma once
#include <array>
#include <cstdint>
#include <tapestry/core/random.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/geometry/transform.hpp>
#include <vector>

namespace tapestry::test {

/// Separate triangles, three positions each; every corner has its own uv.
inline geometry::Mesh triangle_soup(const std::vector<std::array<geometry::Vector3, 3>>& triangles,
                                    const std::array<std::array<double, 2>, 3>& uvs = {
                                        {{0, 0}, {1, 0}, {0, 1}}}) {
  geometry::Mesh mesh;
  for (const auto& triangle : triangles) {
    const auto first = static_cast<std::int32_t>(mesh.positions.size());
    for (const geometry::Vector3& corner : triangle) mesh.positions.push_back(corner);
    for (const auto& uv : uvs) mesh.uvs.push_back(uv);
    mesh.faces.push_back({first, first + 1, first + 2});
    mesh.face_uvs.push_back({first, first + 1, first + 2});
    mesh.face_materials.push_back(-1);
  }
  return mesh;
}

/// Triangles with corners drawn from a box in front of the default camera, which looks along +z with a
/// field of view of 90°; uvs random in [low_uv, high_uv).
inline geometry::Mesh random_triangles(std::size_t count, std::uint64_t seed, double size = 0.5,
                                       double low_uv = 0, double high_uv = 1) {
  Random random(seed);
  std::vector<std::array<geometry::Vector3, 3>> triangles(count);
  for (auto& triangle : triangles) {
    const geometry::Vector3 centre{random.uniform(-2, 2), random.uniform(-2, 2), random.uniform(1.5, 4)};
    for (auto& corner : triangle) {
      for (std::size_t axis = 0; axis < 3; ++axis) corner[axis] = centre[axis] + random.uniform(-size, size);
    }
  }
  geometry::Mesh mesh = triangle_soup(triangles);
  for (auto& uv : mesh.uvs) uv = {random.uniform(low_uv, high_uv), random.uniform(low_uv, high_uv)};
  return mesh;
}

}  // namespace tapestry::test

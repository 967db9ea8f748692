#pragma once
#include <numbers>
#include <tapestry/core/random.hpp>
#include <tapestry/geometry/shapes.hpp>

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

/// A closed sphere of about radius 1 whose surface is raised and lowered by waves, up to `height`.
inline geometry::Mesh bumpy_sphere(std::size_t subdivisions, double height, std::uint64_t seed) {
  Random random(seed);
  const geometry::Vector3 wave{random.uniform(3, 9), random.uniform(3, 9), random.uniform(3, 9)};
  geometry::Mesh mesh = geometry::icosphere(subdivisions);
  for (auto& p : mesh.positions)
    p = geometry::scale(
        p, 1 + height * std::sin(wave[0] * p[0] + 1) * std::sin(wave[1] * p[1]) * std::cos(wave[2] * p[2]));
  return mesh;
}

/// An open tube along x, from −1 to 1, every second ring narrower: with many faces around or many rings they
/// are needles.
inline geometry::Mesh needle_tube(std::int32_t around, std::int32_t rings, double radius) {
  geometry::Mesh mesh;
  for (std::int32_t ring = 0; ring <= rings; ++ring)
    for (std::int32_t i = 0; i < around; ++i) {
      const double turn = 2 * std::numbers::pi * i / around,
                   width = radius * (1 + 0.2 * std::sin(3.0 * ring));
      mesh.positions.push_back({-1 + 2.0 * ring / rings, width * std::cos(turn), radius * std::sin(turn)});
    }
  for (std::int32_t ring = 0; ring < rings; ++ring)
    for (std::int32_t i = 0; i < around; ++i) {
      const std::int32_t a = ring * around + i, b = ring * around + (i + 1) % around;
      mesh.faces.insert(mesh.faces.end(), {{a, b, b + around}, {a, b + around, a + around}});
    }
  return mesh;
}
}  // namespace tapestry::test

#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <map>
#include <tapestry/core/error.hpp>
#include <tapestry/geometry/icosphere.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/geometry/transform.hpp>
#include <utility>
#include <vector>

namespace tapestry::geometry::detail {

/// Its corners on the sphere of radius 1.
[[nodiscard]] inline Mesh icosahedron() {
  Mesh mesh;
  const double g = (1 + std::sqrt(5.0)) / 2;  // the corners are those of three golden rectangles
  for (std::size_t axis = 0; axis < 3; ++axis)
    for (const auto& [one, golden] : {std::pair{-1.0, -g}, {1.0, -g}, {-1.0, g}, {1.0, g}}) {
      Vector3 corner{};
      corner[axis] = one;
      corner[(axis + 1) % 3] = golden;
      mesh.positions.push_back(normalised(corner));
    }
  const auto corner = [&](std::int32_t i) { return mesh.positions[static_cast<std::size_t>(i)]; };
  const auto are_neighbours = [&](std::int32_t i, std::int32_t j) {
    return dot(corner(i), corner(j)) > 0.4;  // 1/√5; it is −1/√5 or −1 of the others
  };
  for (std::int32_t a = 0; a < 12; ++a)
    for (std::int32_t b = a + 1; b < 12; ++b)
      for (std::int32_t c = b + 1; c < 12; ++c) {
        if (!are_neighbours(a, b) || !are_neighbours(b, c) || !are_neighbours(c, a)) continue;
        const bool is_outwards = dot(cross(corner(a), corner(b)), corner(c)) > 0;
        mesh.faces.push_back(is_outwards ? Corners{a, b, c} : Corners{a, c, b});
      }
  return mesh;
}

/// Cuts every face of a sphere of radius 1 into four.
inline void subdivide_sphere(Mesh& mesh) {
  std::map<std::pair<std::int32_t, std::int32_t>, std::int32_t> middles;
  const auto middle = [&](std::int32_t a, std::int32_t b) {
    const auto [at, is_new] =
        middles.try_emplace(std::minmax(a, b), static_cast<std::int32_t>(mesh.positions.size()));
    if (is_new)
      mesh.positions.push_back(normalised(
          add(mesh.positions[static_cast<std::size_t>(a)], mesh.positions[static_cast<std::size_t>(b)])));
    return at->second;
  };
  std::vector<Corners> faces;
  for (const auto& [a, b, c] : mesh.faces) {
    const std::int32_t ab = middle(a, b), bc = middle(b, c), ca = middle(c, a);
    faces.insert(faces.end(), {{a, ab, ca}, {ab, b, bc}, {ca, bc, c}, {ab, bc, ca}});
  }
  mesh.faces = std::move(faces);
}

}  // namespace tapestry::geometry::detail

namespace tapestry::geometry {

Mesh icosphere(std::size_t subdivisions, double radius, const Vector3& centre) {
  if (subdivisions > 8) throw DomainError("icosphere: expected at most 8 subdivisions");
  if (!(radius > 0)) throw DomainError("icosphere: the radius must be positive");
  Mesh mesh = detail::icosahedron();
  for (std::size_t n = 0; n < subdivisions; ++n) detail::subdivide_sphere(mesh);
  for (Vector3& position : mesh.positions) position = add(scale(position, radius), centre);
  return mesh;
}

}  // namespace tapestry::geometry

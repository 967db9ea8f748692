#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/geometry/mesh_topology.hpp>
#include <vector>

namespace tapestry::geometry {

MeshTopology mesh_topology(const Mesh& mesh) {
  struct HalfEdge {
    std::array<std::size_t, 2> ends;
    std::size_t opposite;
  };
  std::vector<HalfEdge> halves;
  halves.reserve(3 * mesh.faces.size());
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    std::array<std::size_t, 3> corner{};
    for (std::size_t k = 0; k < 3; ++k) {
      corner[k] = static_cast<std::size_t>(mesh.faces[face][k]);  // of a negative one, beyond any size
      if (corner[k] >= mesh.positions.size())
        throw Error(ErrorKind::mismatch, "mesh_topology: face " + std::to_string(face) +
                                             " refers to position " + std::to_string(mesh.faces[face][k]) +
                                             " of " + std::to_string(mesh.positions.size()));
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [low, high] = std::minmax(corner[k], corner[(k + 1) % 3]);
      if (low != high) halves.push_back({{low, high}, corner[(k + 2) % 3]});
    }
  }
  std::stable_sort(halves.begin(), halves.end(),
                   [](const HalfEdge& a, const HalfEdge& b) { return a.ends < b.ends; });
  MeshTopology topology{mesh.positions.size(), {}, {}};
  for (std::size_t begin = 0, end = 0; begin < halves.size(); begin = end) {
    while (end < halves.size() && halves[end].ends == halves[begin].ends) ++end;
    const auto& ends = halves[begin].ends;
    topology.edges.push_back(ends);
    if (end == begin + 2)
      topology.hinges.push_back({ends[0], ends[1], halves[begin].opposite, halves[begin + 1].opposite});
  }
  return topology;
}

}  // namespace tapestry::geometry

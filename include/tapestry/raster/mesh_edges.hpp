#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <numeric>
#include <tapestry/geometry/mesh.hpp>
#include <vector>

namespace tapestry::raster {

/// Side of a face: from its corner `corner` to the next one.
struct HalfEdge {
  std::int32_t face;
  std::int32_t corner;
};

/// The edges of a mesh, each with all faces that have it: one at a border, two inside, more where surfaces
/// meet or faces are repeated. Positions with the same coordinates count as one, so that a seam of duplicated
/// vertices is no border.
struct MeshEdges {
  std::vector<std::int32_t> welded;  ///< for each position the first one with its coordinates
  std::vector<HalfEdge> half_edges;  ///< edge by edge; in each edge by face
  std::vector<std::uint32_t> begin;  ///< first half-edge of each edge, and the end
};

[[nodiscard]] inline std::vector<std::int32_t> welded_positions(const geometry::Mesh& mesh) {
  std::vector<std::int32_t> order(mesh.positions.size());
  std::iota(order.begin(), order.end(), 0);
  const auto& positions = mesh.positions;
  const auto at = [&](std::int32_t index) -> const std::array<double, 3>& {
    return positions[static_cast<std::size_t>(index)];
  };
  // NaN has no place in an order; such positions are left alone.
  const auto middle = std::partition(order.begin(), order.end(), [&](std::int32_t index) {
    return at(index)[0] == at(index)[0] && at(index)[1] == at(index)[1] && at(index)[2] == at(index)[2];
  });
  std::sort(order.begin(), middle,
            [&](std::int32_t a, std::int32_t b) { return at(a) != at(b) ? at(a) < at(b) : a < b; });
  std::vector<std::int32_t> welded(positions.size());
  std::iota(welded.begin(), welded.end(), 0);
  for (auto i = order.begin(); i != middle; ++i) {
    if (i != order.begin() && at(*i) == at(*(i - 1)))
      welded[static_cast<std::size_t>(*i)] = welded[static_cast<std::size_t>(*(i - 1))];
  }
  return welded;
}

/// \pre every corner of every face exists, see require_corners()
[[nodiscard]] inline MeshEdges mesh_edges(const geometry::Mesh& mesh) {
  struct Side {
    std::uint64_t key;  // both ends
    HalfEdge half_edge;
  };
  MeshEdges edges;
  edges.welded = welded_positions(mesh);
  std::vector<Side> sides;
  sides.reserve(3 * mesh.faces.size());
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    for (std::int32_t corner = 0; corner < 3; ++corner) {
      const auto end = [&](std::int32_t k) {
        const auto index = static_cast<std::size_t>(mesh.faces[face][static_cast<std::size_t>(k % 3)]);
        return static_cast<std::uint32_t>(edges.welded[index]);
      };
      const auto [low, high] = std::minmax({end(corner), end(corner + 1)});
      if (low == high) continue;
      sides.push_back({std::uint64_t{low} << 32U | high, {static_cast<std::int32_t>(face), corner}});
    }
  }
  std::stable_sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) { return a.key < b.key; });
  edges.half_edges.reserve(sides.size());
  for (std::size_t i = 0; i < sides.size(); ++i) {
    if (i == 0 || sides[i].key != sides[i - 1].key) edges.begin.push_back(static_cast<std::uint32_t>(i));
    edges.half_edges.push_back(sides[i].half_edge);
  }
  edges.begin.push_back(static_cast<std::uint32_t>(sides.size()));
  return edges;
}

}  // namespace tapestry::raster

#pragma once
#include <cstddef>
#include <cstdint>
#include <span>
#include <tapestry/core/compiled.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <vector>

namespace tapestry::raster {

/// Side of a face: from its corner `corner` to the next one.
struct HalfEdge {
  std::int32_t face;
  std::int32_t corner;
};

/// The edges of a mesh, as long as its faces stay and wherever its positions go: each with all faces that
/// have it: one at a border, two inside, more where surfaces meet or faces are repeated. Positions that had
/// the same coordinates when the edges were made count as one, so that a seam of duplicated vertices is no
/// border.
struct MeshEdges {
  std::vector<std::int32_t> welded;  ///< for each position the first one with its coordinates
  std::vector<HalfEdge> half_edges;  ///< edge by edge; in each edge by face
  std::vector<std::uint32_t> begin;  ///< first half-edge of each edge, and the end
  /// Of an edge of two faces 1 if they run along it in opposite ways, as on a surface with one side outwards,
  /// −1 if alike, doubled at a seam, where they have positions of their own; 0 for other edges.
  std::vector<std::int8_t> way;
  std::size_t face_count = 0;
  /// Whether each edge has two faces, which run along it in opposite ways, and all faces hang together: one
  /// surface without borders that has one side outwards.
  bool is_closed = false;

  [[nodiscard]] std::size_t size() const { return begin.size() - 1; }
  [[nodiscard]] std::span<const HalfEdge> of(std::size_t edge) const {
    return {half_edges.data() + begin[edge], begin[edge + 1] - begin[edge]};
  }
};

/// For each position the first one with its coordinates; those that are NaN stay alone. A hash table with
/// open addressing.
[[nodiscard]] std::vector<std::int32_t> welded_positions(const geometry::Mesh& mesh);

/// \pre every corner of every face exists, see require_corners()
[[nodiscard]] MeshEdges mesh_edges(const geometry::Mesh& mesh);

}  // namespace tapestry::raster

#pragma once
#include <array>
#include <cstddef>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <vector>

namespace tapestry::geometry {

/// What is beside what on a mesh, by indices into its positions. Positions that coincide are not one.
struct MeshTopology {
  /// Two faces with a common edge (a, b); c and d are their third corners.
  struct Hinge {
    std::size_t a, b, c, d;
  };
  std::size_t vertex_count = 0;
  std::vector<std::array<std::size_t, 2>> edges;  ///< each once, the lower index first, ascending
  std::vector<Hinge> hinges;                      ///< of the edges of exactly two faces, ascending
};

/// \throws Error (mismatch) if a face refers to a missing position
[[nodiscard]] MeshTopology mesh_topology(const Mesh& mesh);

}  // namespace tapestry::geometry

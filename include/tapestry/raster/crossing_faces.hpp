#pragma once
#include <compare>
#include <cstdint>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/raster/mesh_edges.hpp>
#include <tapestry/raster/seen_faces.hpp>
#include <vector>

namespace tapestry::raster {

/// Two faces, the lower index first.
struct FacePair {
  std::int32_t first;
  std::int32_t second;
  auto operator<=>(const FacePair&) const = default;
};

/// The pairs of faces that may cut through each other where one pixel shows both, or one the one and a
/// neighbour the other, in order: those without a corner in common of which each has points on both sides of
/// the other one's plane. Where a line of intersection shows, samples on both sides of it see the two faces,
/// unless it is shorter than they are apart. Those samples may lie in two pixels; such are compared where
/// both show at most two faces, for a line between pixels that is not found there is one of many short ones.
/// The result is the same for any number of threads, and wherever the mesh lies, as far as doubles hold it
/// there.
/// \param edges  of the same mesh
[[nodiscard]] std::vector<FacePair> crossing_faces(const geometry::Mesh& mesh, const MeshEdges& edges,
                                                   const SeenFaces& seen);

}  // namespace tapestry::raster

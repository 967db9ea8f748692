#pragma once
#include <array>
#include <cstddef>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <vector>

namespace tapestry::raster {

/// How much of the sky each corner of a mesh sees, from either side of its face; linear in between.
struct AmbientOcclusion {
  /// Of the side to which the corners run counter-clockwise, then of the other, [F][side][corner], in [0, 1].
  std::vector<std::array<std::array<float, 3>, 2>> open;

  /// At barycentric coordinates of a face, seen from its side 0 or 1.
  [[nodiscard]] double at(std::size_t face, std::size_t side, const std::array<double, 3>& b) const;
};

/// Bakes the ambient occlusion of a mesh by itself, once for all views:
///
///   open = ∫ V(ω) · max(0, n·ω) dω / π
///
/// with V the mesh's own visibility, seen by ParallelView from `directions` directions all around, of which
/// half are above any side, weighted by their cosines. A face is looked at in three points, a quarter of the
/// way from its corners to its middle; its corners follow by a linear function. On ground beside a wall, the
/// error is at most 0.008 with 1024 directions, and 0.03 in the row of faces that touches the wall.
///
/// \param directions  1 to 65536
/// \param pixels      of each of these views
/// \throws DomainError for numbers out of range; Error (mismatch) as ParallelView
[[nodiscard]] AmbientOcclusion ambient_occlusion(const geometry::Mesh& mesh, std::size_t directions = 512,
                                                 std::size_t pixels = 256);

}  // namespace tapestry::raster

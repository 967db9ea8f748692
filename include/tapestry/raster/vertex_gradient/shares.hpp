#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <tapestry/geometry/camera.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/geometry/transform.hpp>
#include <vector>

namespace tapestry::raster::detail {

/// A part of the derivative with respect to one position, in view space.
struct VertexShare {
  std::int32_t vertex;
  geometry::Vector3 adjoint_view;
};

/// Adds shares to the derivatives with respect to positions of the world, block by block, so that the sums do
/// not depend on which thread made which block.
inline void add_shares(const std::vector<std::vector<VertexShare>>& blocks, const geometry::Camera& camera,
                       std::vector<geometry::Vector3>& positions_adjoint) {
  for (const auto& block : blocks) {
    for (const VertexShare& share : block) {
      geometry::Vector3& sum = positions_adjoint[static_cast<std::size_t>(share.vertex)];
      sum = geometry::add(sum, geometry::multiply_transposed(camera.rotation, share.adjoint_view));
    }
  }
}

inline std::array<geometry::Vector3, 3> corners_in_view(const geometry::Mesh& mesh,
                                                        const std::vector<geometry::Vector3>& positions_view,
                                                        std::int32_t face) {
  std::array<geometry::Vector3, 3> corners;
  for (std::size_t k = 0; k < 3; ++k)
    corners[k] = positions_view[static_cast<std::size_t>(mesh.faces[static_cast<std::size_t>(face)][k])];
  return corners;
}

/// Corner k of a face, k also 3 or 4.
inline std::int32_t corner_of(const geometry::Mesh& mesh, std::int32_t face, std::int32_t k) {
  return mesh.faces[static_cast<std::size_t>(face)][static_cast<std::size_t>(k % 3)];
}

/// Cuts a segment of the picture at the borders of pixels, and each part into equal pieces of at most
/// `longest` pixels: calls visit(column, row, length) with the middle of each.
template <class Visit>
void for_each_piece(const std::array<double, 2>& from, const std::array<double, 2>& to, double longest,
                    Visit visit) {
  const std::array<double, 2> way{to[0] - from[0], to[1] - from[1]};
  const double length = std::hypot(way[0], way[1]);
  if (!(length > 0)) return;
  std::array<double, 2> border;  // the next one along each axis
  for (std::size_t axis = 0; axis < 2; ++axis)
    border[axis] = way[axis] > 0 ? std::floor(from[axis]) + 1 : std::ceil(from[axis]) - 1;
  double begin = 0;
  while (begin < 1) {
    std::array<double, 2> reached{1, 1};
    for (std::size_t axis = 0; axis < 2; ++axis)
      if (way[axis] != 0) reached[axis] = (border[axis] - from[axis]) / way[axis];
    const double end = std::min({reached[0], reached[1], 1.0});
    for (std::size_t axis = 0; axis < 2; ++axis)
      if (reached[axis] <= end) border[axis] += way[axis] > 0 ? 1 : -1;
    const double part = (end - begin) * length;
    if (!(part > 0)) continue;
    const double count = std::max(std::ceil(part / longest), 1.0);
    for (double i = 0; i < count; ++i) {
      const double t = begin + (end - begin) * (i + 0.5) / count;
      visit(from[0] + t * way[0], from[1] + t * way[1], part / count);
    }
    begin = end;
  }
}

}  // namespace tapestry::raster::detail

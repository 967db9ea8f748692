#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <tapestry/core/parallel.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/geometry/transform.hpp>
#include <tapestry/raster/crossing_faces.hpp>
#include <tapestry/raster/mesh_edges.hpp>
#include <tapestry/raster/seen_faces.hpp>
#include <vector>

namespace tapestry::raster::detail {

/// Whether a face has points on both sides of another one's plane, or may have, and is not in that plane.
/// What counts as in it is measured by the two faces alone, so that no third one matters.
[[nodiscard]] inline bool reaches_through(const std::array<geometry::Vector3, 3>& face,
                                          const std::array<geometry::Vector3, 3>& plane) {
  const geometry::Vector3 u = geometry::subtract(plane[1], plane[0]);
  const geometry::Vector3 v = geometry::subtract(plane[2], plane[0]);
  const geometry::Vector3 normal = geometry::cross(u, v);
  // What a height may be off by: the sum of its terms' sizes, times 90 roundings of a double.
  const auto rounding = [&](const geometry::Vector3& d) {
    const auto term = [&](std::size_t x, std::size_t y, std::size_t z) {
      return (std::abs(u[y] * v[z]) + std::abs(u[z] * v[y])) * std::abs(d[x]);
    };
    return 1e-14 * (term(0, 1, 2) + term(1, 2, 0) + term(2, 0, 1));
  };
  const geometry::Vector3 away = geometry::subtract(face[0], plane[0]);
  const double height = geometry::dot(normal, away);
  double low = 0, high = 0, rise_rounding = 0;  // of the face over its first corner
  for (std::size_t k = 1; k < 3; ++k) {
    const geometry::Vector3 side = geometry::subtract(face[k], face[0]);
    const double rise = geometry::dot(normal, side);
    low = std::min(low, rise);
    high = std::max(high, rise);
    rise_rounding = std::max(rise_rounding, rounding(side));
  }
  const double either = rounding(away) + rise_rounding;
  return height + low <= either && height + high >= -either && high - low > rise_rounding;
}

/// Whether two faces have no corner in common but boxes that overlap, and each reaches through the other.
/// Faces with a common corner meet there, and are taken not to cut each other elsewhere.
[[nodiscard]] inline bool may_cut(const geometry::Mesh& mesh, const MeshEdges& edges, const FacePair& pair) {
  const geometry::Corners& first = mesh.faces[static_cast<std::size_t>(pair.first)];
  const geometry::Corners& second = mesh.faces[static_cast<std::size_t>(pair.second)];
  const auto welded = [&](std::int32_t corner) { return edges.welded[static_cast<std::size_t>(corner)]; };
  for (const std::int32_t own : first)
    for (const std::int32_t its : second)
      if (welded(own) == welded(its)) return false;
  const auto corners_of = [&](const geometry::Corners& face) {
    std::array<geometry::Vector3, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) corners[k] = mesh.positions[static_cast<std::size_t>(face[k])];
    return corners;
  };
  const auto a = corners_of(first), b = corners_of(second);
  for (std::size_t axis = 0; axis < 3; ++axis) {
    const auto [low_a, high_a] = std::minmax({a[0][axis], a[1][axis], a[2][axis]});
    const auto [low_b, high_b] = std::minmax({b[0][axis], b[1][axis], b[2][axis]});
    if (!(low_a <= high_b && low_b <= high_a)) return false;
  }
  return reaches_through(a, b) && reaches_through(b, a);
}

/// Calls compare(face, face) for pairs that only together two neighbouring pixels show. Where pixels show
/// more than two faces, faces are small, and a line that is missed is short.
template <class Compare>
void compare_across(std::span<const std::int32_t> faces, std::span<const std::int32_t> beside,
                    Compare compare) {
  constexpr std::size_t most_faces = 2;
  if (faces.size() > most_faces || beside.size() > most_faces || std::ranges::equal(faces, beside)) return;
  for (const std::int32_t one : faces)
    if (std::ranges::find(beside, one) == beside.end())
      for (const std::int32_t other : beside)
        if (std::ranges::find(faces, other) == faces.end()) compare(one, other);
}

/// Each pair once, in order.
inline void keep_once(std::vector<FacePair>& pairs) {
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
}

}  // namespace tapestry::raster::detail

namespace tapestry::raster {

std::vector<FacePair> crossing_faces(const geometry::Mesh& mesh, const MeshEdges& edges,
                                     const SeenFaces& seen) {
  std::vector<std::vector<FacePair>> found(seen.bands().size());
  parallel_for(found.size(), [&](std::size_t index) {
    const SeenFaces::Band& band = seen.bands()[index];
    std::vector<FacePair>& pairs = found[index];
    std::size_t most = 4096;  // which are kept, each maybe several times
    const auto compare = [&](std::int32_t one, std::int32_t other) {
      const FacePair pair{std::min(one, other), std::max(one, other)};
      if (detail::may_cut(mesh, edges, pair)) pairs.push_back(pair);
    };
    std::size_t column = 0;
    for (std::size_t pixel = band.first_pixel(); pixel < band.end_pixel(); ++pixel) {
      const auto faces = band.at(pixel);
      for (std::size_t i = 1; i < faces.size(); ++i)
        for (std::size_t j = 0; j < i; ++j) compare(faces[i], faces[j]);
      if (++column == seen.width())
        column = 0;
      else
        detail::compare_across(faces, band.at(pixel + 1), compare);
      const std::size_t below = pixel + seen.width();
      detail::compare_across(faces, below < band.end_pixel() ? band.at(below) : seen.at(below), compare);
      if (pairs.size() < most) continue;
      detail::keep_once(pairs);
      most = std::max(most, 2 * pairs.size());
    }
  });
  std::vector<FacePair> all;
  for (auto& part : found) {
    all.insert(all.end(), part.begin(), part.end());
    part = {};
  }
  detail::keep_once(all);
  return all;
}

}  // namespace tapestry::raster

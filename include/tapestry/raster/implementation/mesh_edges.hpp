#pragma once
#include <bit>
#include <numeric>
#include <tapestry/raster/detail/crossing_faces.hpp>
#include <tuple>

namespace tapestry::raster {
namespace detail {
[[nodiscard]] inline std::int8_t way_of(const geometry::Mesh& mesh, const MeshEdges& edges,
                                        std::span<const HalfEdge> own) {
  if (own.size() != 2) return 0;
  const auto end = [&](std::size_t i, std::int32_t step) {
    const auto face = static_cast<std::size_t>(own[i].face);
    return mesh.faces[face][static_cast<std::size_t>((own[i].corner + step) % 3)];
  };
  const auto welded = [&](std::int32_t vertex) { return edges.welded[static_cast<std::size_t>(vertex)]; };
  const bool is_alike = welded(end(0, 0)) == welded(end(1, 0));
  const bool is_seam = end(0, 0) != end(1, is_alike ? 0 : 1) || end(0, 1) != end(1, is_alike ? 1 : 0);
  return static_cast<std::int8_t>((is_alike ? -1 : 1) * (is_seam ? 2 : 1));
}

[[nodiscard]] inline bool is_one_piece(const MeshEdges& edges) {
  std::vector<std::int32_t> parent(edges.face_count);
  std::iota(parent.begin(), parent.end(), 0);
  const auto root_of = [&](std::int32_t face) {
    const auto at = [&](std::int32_t i) -> std::int32_t& { return parent[static_cast<std::size_t>(i)]; };
    while (at(face) != face) face = at(face) = at(at(face));
    return face;
  };
  std::size_t pieces = edges.face_count;
  for (std::size_t edge = 0; edge < edges.size(); ++edge)
    for (const HalfEdge& half_edge : edges.of(edge)) {
      const std::int32_t a = root_of(edges.of(edge).front().face), b = root_of(half_edge.face);
      if (a == b) continue;
      parent[static_cast<std::size_t>(std::max(a, b))] = std::min(a, b);
      --pieces;
    }
  return pieces == 1;
}

/// A side of a face, seen from its lesser end.
struct FaceSide {
  std::int32_t high;  ///< the greater end
  HalfEdge half_edge;
};

/// Calls visit(lesser end, FaceSide) for every side that has a length, face by face.
template <class Visit>
void for_each_side(const geometry::Mesh& mesh, const std::vector<std::int32_t>& welded, Visit visit) {
  for (std::size_t face = 0; face < mesh.faces.size(); ++face)
    for (std::size_t corner = 0; corner < 3; ++corner) {
      const auto end = [&](std::size_t k) {
        return welded[static_cast<std::size_t>(mesh.faces[face][k % 3])];
      };
      const auto [low, high] = std::minmax({end(corner), end(corner + 1)});
      if (low != high)
        visit(static_cast<std::size_t>(low),
              FaceSide{high, {static_cast<std::int32_t>(face), static_cast<std::int32_t>(corner)}});
    }
}

/// Joins the sides that share both ends to edges.
inline void gather_edges(const geometry::Mesh& mesh, MeshEdges& edges) {
  // A counting sort by the lesser end, then each run, which is short, by the greater one.
  std::vector<std::uint32_t> next(mesh.positions.size() + 1, 0);
  for_each_side(mesh, edges.welded, [&](std::size_t low, const FaceSide&) { ++next[low + 1]; });
  for (std::size_t i = 1; i < next.size(); ++i) next[i] += next[i - 1];
  std::vector<FaceSide> sides(next.back());
  for_each_side(mesh, edges.welded,
                [&](std::size_t low, const FaceSide& side) { sides[next[low]++] = side; });
  edges.half_edges.reserve(sides.size());
  std::size_t first = 0;
  for (std::size_t low = 0; low < mesh.positions.size(); ++low) {
    const std::size_t last = next[low];  // now the end of its run
    std::sort(sides.begin() + static_cast<std::ptrdiff_t>(first),
              sides.begin() + static_cast<std::ptrdiff_t>(last), [](const FaceSide& a, const FaceSide& b) {
                return std::tie(a.high, a.half_edge.face, a.half_edge.corner) <
                       std::tie(b.high, b.half_edge.face, b.half_edge.corner);
              });
    for (std::size_t i = first; i < last; ++i) {
      if (i == first || sides[i].high != sides[i - 1].high)
        edges.begin.push_back(static_cast<std::uint32_t>(i));
      edges.half_edges.push_back(sides[i].half_edge);
    }
    first = last;
  }
  edges.begin.push_back(static_cast<std::uint32_t>(sides.size()));
}

/// Whether a face has points on both sides of another one's plane, or may have, and is not in that plane. The
/// tolerance for "in the plane" depends on the two faces alone, so that no third one matters.
[[nodiscard]] inline bool reaches_through(const std::array<geometry::Vector3, 3>& face,
                                          const std::array<geometry::Vector3, 3>& plane) {
  const geometry::Vector3 u = geometry::subtract(plane[1], plane[0]);
  const geometry::Vector3 v = geometry::subtract(plane[2], plane[0]);
  const geometry::Vector3 normal = geometry::cross(u, v);
  // Bound of a height's error: the sum of its terms' sizes, times 90 roundings of a double.
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
/// Faces with a common corner meet there, and are assumed not to cut each other elsewhere.
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

/// Calls compare(face, face) for pairs of faces that neighbouring pixels show. Where pixels show more than
/// two faces, faces are small, and a missed line is short. Both show at least one.
template <class Compare>
void compare_across(std::span<const std::int32_t> faces, std::span<const std::int32_t> beside,
                    Compare compare) {
  constexpr std::size_t most_faces = 2;
  if (faces.size() > most_faces || beside.size() > most_faces) return;
  const auto has = [](std::span<const std::int32_t> shown, std::int32_t face) {
    return shown.front() == face || shown.back() == face;
  };
  for (const std::int32_t one : faces)
    if (!has(beside, one))
      for (const std::int32_t other : beside)
        if (!has(faces, other)) compare(one, other);
}

/// The last pairs of faces that were tested: most pairs come again from pixel to pixel.
class TestedPairs {
 public:
  /// Returns whether a pair is known to have been tested, and keeps it.
  [[nodiscard]] bool has(const FacePair& pair) {
    const std::uint64_t key = std::uint64_t{static_cast<std::uint32_t>(pair.first)} << 32U |
                              static_cast<std::uint32_t>(pair.second);
    std::uint64_t& kept = kept_[(key * 0x9E3779B97F4A7C15U) >> 54U];
    return std::exchange(kept, key) == key;
  }

 private:
  std::array<std::uint64_t, 1024> kept_{};  // no pair is 0: faces differ
};

/// Calls compare(face, face) for the pairs of one pixel row: within pixels, with the next pixel, and with the
/// one below. Inside a face, which is most of the picture, there are none.
template <class Compare>
void compare_row(const SeenFaces& seen, std::size_t row, Compare compare) {
  const SeenFaces::Row own = seen.row(row), below = seen.row(row + 1);
  const std::int32_t *const here = own.shown.data(), *const under = below.shown.data();
  const std::size_t inner = own.shown.empty() ? 0 : std::min(own.shown.size() - 1, below.shown.size());
  for (std::size_t column = 0; column < own.shown.size(); ++column) {
    while (column < inner && ((here[column] ^ here[column + 1]) | (here[column] ^ under[column])) == 0)
      ++column;
    const std::int32_t shown = here[column], right = own.at(column + 1), down = below.at(column);
    if (shown == SeenFaces::none) continue;
    if (shown >= 0 && right >= SeenFaces::none && down >= SeenFaces::none) {  // at most one face each
      if (right >= 0 && right != shown) compare(shown, right);
      if (down >= 0 && down != shown) compare(shown, down);
      continue;
    }
    const auto faces = own.faces(column);
    for (std::size_t i = 1; i < faces.size(); ++i)
      for (std::size_t j = 0; j < i; ++j) compare(faces[i], faces[j]);
    if (right != SeenFaces::none) compare_across(faces, own.faces(column + 1), compare);
    if (down != SeenFaces::none) compare_across(faces, below.faces(column), compare);
  }
}

/// Sorts the pairs and removes duplicates.
inline void keep_once(std::vector<FacePair>& pairs) {
  std::sort(pairs.begin(), pairs.end());
  pairs.erase(std::unique(pairs.begin(), pairs.end()), pairs.end());
}
}  // namespace detail

std::vector<std::int32_t> welded_positions(const geometry::Mesh& mesh) {
  std::vector<std::int32_t> welded(mesh.positions.size());
  const std::size_t size = std::bit_ceil(2 * mesh.positions.size() + 1);
  std::vector<std::int32_t> table(size, -1);
  for (std::size_t i = 0; i < welded.size(); ++i) {
    const geometry::Vector3& position = mesh.positions[i];
    std::uint64_t hash = 0;
    for (const double coordinate : position) {
      hash ^= std::bit_cast<std::uint64_t>(coordinate + 0.0);  // −0 is 0
      hash *= 0x9E3779B97F4A7C15U;
      hash ^= hash >> 32U;
    }
    std::size_t slot = hash & (size - 1);
    while (table[slot] >= 0 && mesh.positions[static_cast<std::size_t>(table[slot])] != position)
      slot = (slot + 1) & (size - 1);
    const bool is_number = position == position;
    if (is_number && table[slot] < 0) table[slot] = static_cast<std::int32_t>(i);
    welded[i] = is_number ? table[slot] : static_cast<std::int32_t>(i);
  }
  return welded;
}

MeshEdges mesh_edges(const geometry::Mesh& mesh) {
  MeshEdges edges;
  edges.welded = welded_positions(mesh);
  detail::gather_edges(mesh, edges);
  edges.way.resize(edges.size());
  for (std::size_t edge = 0; edge < edges.size(); ++edge)
    edges.way[edge] = detail::way_of(mesh, edges, edges.of(edge));
  edges.face_count = mesh.faces.size();
  edges.is_closed =
      std::all_of(edges.way.begin(), edges.way.end(), [](std::int8_t way) { return way > 0; }) &&
      detail::is_one_piece(edges);
  return edges;
}

std::vector<FacePair> crossing_faces(const geometry::Mesh& mesh, const MeshEdges& edges,
                                     const SeenFaces& seen) {
  std::vector<std::vector<FacePair>> found(seen.bands().size());
  parallel_for(found.size(), [&](std::size_t index) {
    std::vector<FacePair>& pairs = found[index];
    std::size_t most = 4096;  // pairs before repeated ones are removed
    detail::TestedPairs tested;
    const auto compare = [&](std::int32_t one, std::int32_t other) {
      const FacePair pair{std::min(one, other), std::max(one, other)};
      if (!tested.has(pair) && detail::may_cut(mesh, edges, pair)) pairs.push_back(pair);
    };
    const auto [begin, end] = block_range(index, found.size() * seen.band_rows(), seen.band_rows());
    for (std::size_t row = begin; row < end; ++row) {
      detail::compare_row(seen, row, compare);
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

#pragma once
#include <algorithm>
#include <array>
#include <atomic>
#include <bit>
#include <cmath>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/geometry/transform.hpp>
#include <tapestry/raster/mesh_edges.hpp>
#include <vector>

namespace tapestry::raster {

/// Two faces, the lower index first.
struct FacePair {
  std::int32_t first;
  std::int32_t second;
  auto operator<=>(const FacePair&) const = default;
};

/// How many pairs crossing_faces() returns at most, unless it is told otherwise: as many as 8192 faces have
/// that all cut each other. While they are sought they take up to 24 bytes each, 768 MiB together.
inline constexpr std::size_t most_crossing_pairs = std::size_t{1} << 25U;

namespace detail {

/// Finds the faces that cut each other by a grid in space: levels of cells, each twice as wide as those of
/// the level below, so that every face lies in at most eight cells of its level. Faces of one level meet in a
/// cell of both; larger ones are looked up from the smaller. Cells share a hash table. A pair is reported in
/// one cell alone, that with the least corner of what the two boxes have in common.
class CrossingSearch {
 public:
  /// \param faces  those that are looked at; mesh and edges must outlive this
  CrossingSearch(const geometry::Mesh& mesh, const MeshEdges& edges, const std::vector<std::int32_t>& faces)
      : mesh_(mesh), edges_(edges) {
    set_boxes(faces);
    fill_buckets();
  }

  /// \throws Error, of kind limit, if there are more than `most`
  [[nodiscard]] std::vector<FacePair> pairs(std::size_t most) const {
    std::vector<std::vector<FacePair>> found(part_count());
    std::atomic<std::size_t> count = 0;
    parallel_for(found.size(), [&](std::size_t part) {
      std::size_t counted = 0;
      const auto add_to_count = [&] {
        const std::size_t added = found[part].size() - counted;
        counted += added;
        if (count.fetch_add(added) + added > most) throw too_many(most);
      };
      for_each_candidate(part, [&](const Box& a, const Box& b, std::size_t bucket) {
        if (!cut(a, b, bucket)) return;
        found[part].push_back({std::min(a.face, b.face), std::max(a.face, b.face)});
        if (found[part].size() - counted == 4096) add_to_count();
      });
      add_to_count();
    });
    std::vector<FacePair> all;
    all.reserve(count);
    for (auto& part : found) {
      all.insert(all.end(), part.begin(), part.end());
      part = {};
    }
    std::sort(all.begin(), all.end());
    return all;
  }

  /// How often two boxes are compared.
  [[nodiscard]] std::size_t candidate_count() const {
    std::size_t count = 0;
    for (std::size_t part = 0; part < part_count(); ++part)
      for_each_candidate(part, [&](const Box&, const Box&, std::size_t) { ++count; });
    return count;
  }

 private:
  struct Box {
    std::array<double, 3> low, high;
    std::int32_t face;
    int level;
  };
  using Cell = std::array<std::int64_t, 3>;
  static constexpr std::size_t part_size = 2048;  // buckets, or boxes

  [[nodiscard]] static Error too_many(std::size_t most) {
    return {ErrorKind::limit, "crossing_faces: more than " + std::to_string(most) +
                                  " pairs of faces cut through each other, expected at most so many"};
  }

  [[nodiscard]] const geometry::Vector3& corner(std::size_t face, std::size_t k) const {
    return mesh_.positions[static_cast<std::size_t>(mesh_.faces[face][k])];
  }

  /// Leaves out faces that are a point, or nowhere.
  void set_boxes(const std::vector<std::int32_t>& faces) {
    boxes_.reserve(faces.size());
    for (const std::int32_t face : faces) {
      Box box{{}, {}, face, 0};
      double extent = 0;
      bool is_near = true;
      for (std::size_t axis = 0; axis < 3; ++axis) {
        const auto at = [&](std::size_t k) { return corner(static_cast<std::size_t>(face), k)[axis]; };
        for (std::size_t k = 0; k < 3; ++k) is_near = is_near && std::abs(at(k)) <= 1e18;
        box.low[axis] = std::min({at(0), at(1), at(2)});
        box.high[axis] = std::max({at(0), at(1), at(2)});
        extent = std::max(extent, box.high[axis] - box.low[axis]);
      }
      if (!is_near || !(extent > 0)) continue;
      box.level = std::max(std::ilogb(extent) + 1, -1000);  // cells at least as wide as the face
      boxes_.push_back(box);
      if (std::find(levels_.begin(), levels_.end(), box.level) == levels_.end()) levels_.push_back(box.level);
    }
    std::sort(boxes_.begin(), boxes_.end(), [](const Box& a, const Box& b) { return a.low[0] < b.low[0]; });
  }

  /// A box is at least 2⁻⁵³ of its coordinates wide, and cells no less, so that 64 bits hold their index.
  [[nodiscard]] static Cell cell_of(const std::array<double, 3>& point, int level) {
    const double per_unit = std::ldexp(1.0, -level);
    Cell cell;
    for (std::size_t axis = 0; axis < 3; ++axis)
      cell[axis] = static_cast<std::int64_t>(std::floor(point[axis] * per_unit));
    return cell;
  }

  /// The buckets of a box's cells, each once.
  /// \param level  that of the box or a higher one, so that its cells are at most eight
  template <class Visit>
  void for_each_bucket(const Box& box, int level, Visit visit) const {
    const Cell first = cell_of(box.low, level), last = cell_of(box.high, level);
    std::array<std::size_t, 8> visited;
    auto end = visited.begin();
    for (std::int64_t x = first[0]; x <= last[0]; ++x)
      for (std::int64_t y = first[1]; y <= last[1]; ++y)
        for (std::int64_t z = first[2]; z <= last[2]; ++z) {
          const std::size_t bucket = bucket_of({x, y, z}, level);
          if (std::find(visited.begin(), end, bucket) != end) continue;
          *end++ = bucket;
          visit(bucket);
        }
  }

  [[nodiscard]] std::size_t bucket_of(const Cell& cell, int level) const {
    auto hash = static_cast<std::uint64_t>(level);
    for (const std::int64_t part : cell) {
      hash = (hash ^ static_cast<std::uint64_t>(part)) * 0x9E3779B97F4A7C15U;
      hash ^= hash >> 32U;
    }
    return hash & (begin_.size() - 2);
  }

  /// A counting sort.
  void fill_buckets() {
    begin_.assign(std::bit_ceil(2 * boxes_.size() + 1) + 1, 0);
    const auto for_each = [&](auto visit) {
      for (std::uint32_t box = 0; box < boxes_.size(); ++box)
        for_each_bucket(boxes_[box], boxes_[box].level, [&](std::size_t bucket) { visit(bucket, box); });
    };
    for_each([&](std::size_t bucket, std::uint32_t) { ++begin_[bucket + 1]; });
    for (std::size_t i = 1; i < begin_.size(); ++i) begin_[i] += begin_[i - 1];
    held_.resize(begin_.back());
    std::vector<std::uint32_t> next(begin_.begin(), begin_.end() - 1);
    for_each([&](std::size_t bucket, std::uint32_t box) { held_[next[bucket]++] = box; });
  }

  [[nodiscard]] std::size_t bucket_part_count() const { return block_count(begin_.size() - 1, part_size); }
  [[nodiscard]] std::size_t part_count() const {
    return bucket_part_count() + block_count(boxes_.size(), part_size);
  }

  /// Calls visit(box, box, bucket) for boxes that a bucket holds both, once a bucket. First come the parts of
  /// the buckets, in which boxes of a level meet, then those of the boxes that look for larger ones.
  template <class Visit>
  void for_each_candidate(std::size_t part, Visit visit) const {
    const std::size_t bucket_parts = bucket_part_count();
    if (part < bucket_parts) {
      const auto [begin, end] = block_range(part, begin_.size() - 1, part_size);
      for (std::size_t bucket = begin; bucket < end; ++bucket) visit_bucket(bucket, visit);
    } else {
      const auto [begin, end] = block_range(part - bucket_parts, boxes_.size(), part_size);
      for (std::size_t box = begin; box < end; ++box) visit_larger(boxes_[box], visit);
    }
  }

  /// Boxes of a bucket come in the order of their low ends, so that the first beyond the high end is the
  /// last.
  template <class Visit>
  void visit_bucket(std::size_t bucket, Visit& visit) const {
    for (std::size_t i = begin_[bucket]; i < begin_[bucket + 1]; ++i) {
      const Box& box = boxes_[held_[i]];
      for (std::size_t j = i + 1; j < begin_[bucket + 1]; ++j) {
        const Box& other = boxes_[held_[j]];
        if (other.low[0] > box.high[0]) break;
        if (other.level == box.level) visit(box, other, bucket);
      }
    }
  }

  template <class Visit>
  void visit_larger(const Box& box, Visit& visit) const {
    for (const int level : levels_) {
      if (level <= box.level) continue;
      for_each_bucket(box, level, [&](std::size_t bucket) {
        for (std::size_t i = begin_[bucket]; i < begin_[bucket + 1]; ++i) {
          const Box& larger = boxes_[held_[i]];
          if (larger.low[0] > box.high[0]) break;
          if (larger.level == level) visit(box, larger, bucket);
        }
      });
    }
  }

  /// Whether two faces may cut each other, and this is the bucket where they are reported.
  /// \param larger  of the level of the bucket's cell
  [[nodiscard]] bool cut(const Box& box, const Box& larger, std::size_t bucket) const {
    int overlaps = 1;
    std::array<double, 3> low;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      low[axis] = std::max(box.low[axis], larger.low[axis]);
      overlaps &= int{low[axis] <= box.high[axis]} & int{low[axis] <= larger.high[axis]};
    }
    if (overlaps == 0) return false;
    const auto i = static_cast<std::size_t>(box.face), j = static_cast<std::size_t>(larger.face);
    return !share_corner(i, j) && bucket_of(cell_of(low, larger.level), larger.level) == bucket &&
           reaches_through(i, j) && reaches_through(j, i);
  }

  [[nodiscard]] bool share_corner(std::size_t i, std::size_t j) const {
    const auto welded = [&](std::size_t face, std::size_t k) {
      return edges_.welded[static_cast<std::size_t>(mesh_.faces[face][k])];
    };
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t l = 0; l < 3; ++l)
        if (welded(i, k) == welded(j, l)) return true;
    return false;
  }

  /// Whether a face has points on both sides of another one's plane, or may have, and is not in that plane.
  /// What counts as in it is measured by the two faces alone, so that no third one matters.
  [[nodiscard]] bool reaches_through(std::size_t face, std::size_t plane) const {
    const geometry::Vector3& origin = corner(plane, 0);
    const geometry::Vector3 u = geometry::subtract(corner(plane, 1), origin);
    const geometry::Vector3 v = geometry::subtract(corner(plane, 2), origin);
    const geometry::Vector3 normal = geometry::cross(u, v);
    // What a height may be off by: the sum of its terms' sizes, times 90 roundings of a double.
    const auto rounding = [&](const geometry::Vector3& d) {
      const auto term = [&](std::size_t x, std::size_t y, std::size_t z) {
        return (std::abs(u[y] * v[z]) + std::abs(u[z] * v[y])) * std::abs(d[x]);
      };
      return 1e-14 * (term(0, 1, 2) + term(1, 2, 0) + term(2, 0, 1));
    };
    const geometry::Vector3 away = geometry::subtract(corner(face, 0), origin);
    const double height = geometry::dot(normal, away);
    double low = 0, high = 0, rise_rounding = 0;  // of the face over its first corner
    for (std::size_t k = 1; k < 3; ++k) {
      const geometry::Vector3 side = geometry::subtract(corner(face, k), corner(face, 0));
      const double rise = geometry::dot(normal, side);
      low = std::min(low, rise);
      high = std::max(high, rise);
      rise_rounding = std::max(rise_rounding, rounding(side));
    }
    const double either = rounding(away) + rise_rounding;
    return height + low <= either && height + high >= -either && high - low > rise_rounding;
  }

  const geometry::Mesh& mesh_;
  const MeshEdges& edges_;
  std::vector<Box> boxes_;
  std::vector<int> levels_;           // that have faces
  std::vector<std::uint32_t> begin_;  // of each bucket
  std::vector<std::uint32_t> held_;   // boxes, bucket by bucket
};

}  // namespace detail

/// The pairs of some faces of a mesh that may cut through each other, in order: those without a corner in
/// common of which each has points on both sides of the other one's plane. Faces with a common corner meet
/// there, and are taken not to cut each other elsewhere. The result is the same for any number of threads,
/// and wherever the mesh lies, as far as doubles hold it there; coordinates beyond 1e18 are left out.
/// \param edges  of the same mesh
/// \param faces  each once
/// \throws Error, of kind limit, if there are more than `most` pairs
[[nodiscard]] inline std::vector<FacePair> crossing_faces(const geometry::Mesh& mesh, const MeshEdges& edges,
                                                          const std::vector<std::int32_t>& faces,
                                                          std::size_t most = most_crossing_pairs) {
  return detail::CrossingSearch(mesh, edges, faces).pairs(most);
}

}  // namespace tapestry::raster

#pragma once
#include <span>
#include <tapestry/core/array.hpp>
#include <tapestry/geometry/mesh.hpp>

namespace tapestry::geometry {
/// A point of a plane.
using Vector2 = std::array<double, 2>;

/// Whether a, b, c turn to the left (1), to the right (−1) or lie on one line (0): the sign of
///
///   (b − a) × (c − a) = aₓb_y − a_ybₓ + bₓc_y − b_ycₓ + cₓa_y − c_yaₓ
///
/// without rounding, as long as no product leaves the range of normal doubles (coordinates that are 0 or from
/// 1e-130 to 1e130 are safe). Where rounding cannot change the sign, it costs two products.
/// Source of the bound: Shewchuk (1997), figure 21.
///
/// \param a,b,c  points of a plane, any unit
[[nodiscard]] int orientation(const Vector2& a, const Vector2& b, const Vector2& c);

/// Finds which points of a plane lie in a triangle. The n points stand in about √n columns of as many points
/// each, by x, and by y within a column. A search visits the columns that the triangle crosses, between the
/// heights it has there; a thin triangle takes about √n · log n steps, however the points are spread.
class PointColumns {
 public:
  /// \param points  finite
  void build(std::span<const Vector2> points) {
    entries_.resize(points.size());
    for (std::size_t i = 0; i < points.size(); ++i) entries_[i] = {points[i], i};
    std::ranges::sort(entries_, {}, [](const Entry& entry) { return entry.point[0]; });
    depth_ = static_cast<std::size_t>(std::ceil(std::sqrt(static_cast<double>(points.size()))));
    columns_.clear();
    for (std::size_t begin = 0; begin < entries_.size(); begin += depth_) {
      const std::span<Entry> column(entries_.data() + begin, std::min(depth_, entries_.size() - begin));
      columns_.push_back({column.front().point[0], column.back().point[0]});
      std::ranges::sort(column, {}, [](const Entry& entry) { return entry.point[1]; });
    }
  }

  void clear() { columns_.clear(); }

  /// Columns; 0 before build().
  [[nodiscard]] std::size_t size() const { return columns_.size(); }

  /// Calls answers(index) for every point inside a triangle or on its border, and for some others near it,
  /// until it returns true.
  ///
  /// \param steps  increased by the number of columns and points visited
  /// \returns      whether it returned true for one
  template <class Answers>
  [[nodiscard]] bool any_in(const std::array<Vector2, 3>& triangle, std::uint64_t& steps,
                            Answers answers) const {
    const auto [low, high] = std::minmax({triangle[0][0], triangle[1][0], triangle[2][0]});
    auto column = std::ranges::lower_bound(columns_, low, {}, &Column::high);
    for (; column != columns_.end() && column->low <= high; ++column) {
      const auto [bottom, top] = heights(triangle, column->low, column->high);
      const auto begin = static_cast<std::size_t>(column - columns_.begin()) * depth_;
      const std::span<const Entry> entries(entries_.data() + begin,
                                           std::min(depth_, entries_.size() - begin));
      auto entry =
          std::ranges::lower_bound(entries, bottom, {}, [](const Entry& each) { return each.point[1]; });
      ++steps;
      for (; entry != entries.end() && entry->point[1] <= top; ++entry) {
        ++steps;
        if (entry->point[0] >= low && entry->point[0] <= high && answers(entry->index)) return true;
      }
    }
    return false;
  }

 private:
  struct Entry {
    Vector2 point;
    std::size_t index;
  };
  struct Column {
    double low, high;  ///< of x
  };

  /// The least and greatest height of a triangle between two x, and a little more for rounding.
  [[nodiscard]] static std::array<double, 2> heights(const std::array<Vector2, 3>& triangle, double from,
                                                     double to) {
    constexpr double infinity = std::numeric_limits<double>::infinity();
    std::array<double, 2> range{infinity, -infinity};
    for (std::size_t i = 0; i < 3; ++i) {
      Vector2 a = triangle[i], b = triangle[(i + 1) % 3];
      if (a[0] > b[0]) std::swap(a, b);
      const double left = std::max(a[0], from), right = std::min(b[0], to);
      if (left > right) continue;
      // Four roundings of 2^-53 of no more than |a| + |b| each, doubled.
      const double slack = 4 * std::numeric_limits<double>::epsilon() * (std::abs(a[1]) + std::abs(b[1]));
      const auto include = [&](double y) {
        range = {std::min(range[0], y - slack), std::max(range[1], y + slack)};
      };
      if (a[0] == b[0]) {
        include(a[1]);
        include(b[1]);
        continue;
      }
      for (const double x : {left, right}) include(a[1] + (b[1] - a[1]) * ((x - a[0]) / (b[0] - a[0])));
    }
    return range;
  }

  std::vector<Entry> entries_;
  std::vector<Column> columns_;
  std::size_t depth_ = 0;
};

/// The positions of a mesh in the tape's form, [V, 3].
template <std::floating_point T>
[[nodiscard]] Array<T, 2> position_array(const Mesh& mesh) {
  Array<T, 2> array(Extents<2>{mesh.positions.size(), 3});
  for (std::size_t i = 0; i < array.size(); ++i)
    array.data()[i] = static_cast<T>(mesh.positions[i / 3][i % 3]);
  return array;
}

/// Gives a mesh the positions of an array, [V, 3].
/// \throws ShapeError, which names `operation`, unless there are as many as the mesh has
template <std::floating_point T>
void set_positions(const char* operation, Mesh& mesh, const Array<T, 2>& positions) {
  require_shape(operation, "positions", positions, {mesh.positions.size(), 3});
  for (std::size_t i = 0; i < positions.size(); ++i)
    mesh.positions[i / 3][i % 3] = static_cast<double>(positions.data()[i]);
}
}  // namespace tapestry::geometry

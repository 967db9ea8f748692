#pragma once
#include <bit>
#include <compare>
#include <tapestry/raster/faces_in_view.hpp>

namespace tapestry::raster {

/// Square cells over the part of a picture that a mesh covers.
class CellGrid {
 public:
  /// A range of cells, ends included.
  struct Range {
    std::array<std::int32_t, 2> first, last;
  };

  /// Makes a cell for eight faces, as if the faces were spread evenly; fewer where they lie in more than
  /// about 16 layers, so that the lists of all cells together stay a few times as long as the number of
  /// faces.
  explicit CellGrid(const FacesInView::Extent& extent) {
    std::array<double, 2> low{0, 0}, size{0, 0};
    for (std::size_t axis = 0; extent.count > 0 && axis < 2; ++axis) {
      low[axis] = static_cast<double>(extent.box.low[axis]);
      size[axis] = static_cast<double>(extent.box.high[axis]) - low[axis];
    }
    const double margin = 2e-3;  // so that points just beside an edge have a cell
    const double across = size[0] + 2 * margin, down = size[1] + 2 * margin;
    const auto count = static_cast<double>(std::max<std::size_t>(extent.count, 1));
    const double least = std::max(8 * across * down, extent.area / 2) / count;  // px²
    side_ = std::max(std::sqrt(least), 1e-3 * std::max(across, down));
    cells_per_px_ = 1 / side_;
    origin_ = {low[0] - margin, low[1] - margin};
    columns_ = static_cast<std::int32_t>(across / side_) + 1;
    rows_ = static_cast<std::int32_t>(down / side_) + 1;
  }

  [[nodiscard]] std::size_t size() const { return index(0, rows_); }
  /// Side of a cell, in pixels.
  [[nodiscard]] double side() const { return side_; }

  [[nodiscard]] std::size_t index(std::int32_t x, std::int32_t y) const {
    return static_cast<std::size_t>(y) * static_cast<std::size_t>(columns_) + static_cast<std::size_t>(x);
  }

  /// {column, row} of a cell's middle.
  [[nodiscard]] std::array<double, 2> middle(std::int32_t x, std::int32_t y) const {
    return {origin_[0] + (static_cast<double>(x) + 0.5) * side_,
            origin_[1] + (static_cast<double>(y) + 0.5) * side_};
  }

  /// The cells that a box touches; for a box outside all cells the nearest ones.
  [[nodiscard]] Range cells_of(const std::array<double, 2>& low, const std::array<double, 2>& high) const {
    const auto cell = [&](double value, std::size_t axis, std::int32_t count) {
      const double place = (value - origin_[axis]) * cells_per_px_;
      return static_cast<std::int32_t>(std::clamp(place, 0.0, static_cast<double>(count - 1)));
    };
    return {{cell(low[0], 0, columns_), cell(low[1], 1, rows_)},
            {cell(high[0], 0, columns_), cell(high[1], 1, rows_)}};
  }

  /// Cuts a line at the borders of cells: calls visit(index, from, to) for each segment, in order. Points
  /// outside the grid are in the nearest cells.
  template <class Visit>
  void cut(const std::array<double, 2>& from, const std::array<double, 2>& to, Visit visit) const {
    std::array<std::int32_t, 2> cell = cells_of(from, from).first;
    const std::array<std::int32_t, 2> last = cells_of(to, to).first;
    std::array<double, 2> begin = from;
    while (cell != last) {
      std::array<double, 2> share{2, 2};  // of the line, up to the next cell along each axis
      for (std::size_t axis = 0; axis < 2; ++axis)
        if (cell[axis] != last[axis])
          share[axis] =
              (origin_[axis] + side_ * (cell[axis] + (cell[axis] < last[axis] ? 1 : 0)) - from[axis]) /
              (to[axis] - from[axis]);
      const std::size_t across = share[0] < share[1] ? 0 : 1;
      const double reached = std::clamp(share[across], 0.0, 1.0);
      const std::array<double, 2> end{from[0] + reached * (to[0] - from[0]),
                                      from[1] + reached * (to[1] - from[1])};
      visit(index(cell[0], cell[1]), begin, end);
      cell[across] += cell[across] < last[across] ? 1 : -1;
      begin = end;
    }
    visit(index(cell[0], cell[1]), begin, to);
  }

 private:
  std::array<double, 2> origin_{0, 0};
  double side_ = 1;
  double cells_per_px_ = 1;
  std::int32_t columns_ = 1;
  std::int32_t rows_ = 1;
};

}  // namespace tapestry::raster

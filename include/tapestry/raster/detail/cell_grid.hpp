#pragma once
#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <compare>
#include <cstddef>
#include <cstdint>
#include <tapestry/raster/faces_in_view.hpp>

namespace tapestry::raster {

/// A face in a cell. The low half is its slot. The high half is its farness: the complement of the bits of
/// its greatest 1/z there as a float, so that the nearest face has the least entry.
struct CellEntry {
  std::uint64_t bits;

  [[nodiscard]] static CellEntry of(std::uint32_t farness, std::uint32_t slot) {
    return {std::uint64_t{farness} << 32U | slot};
  }
  [[nodiscard]] static std::uint32_t farness_of(double inverse_depth_max) {
    const float least = static_cast<float>(std::clamp(inverse_depth_max, 0.0, 3e38));
    return ~(std::bit_cast<std::uint32_t>(least) + 1);  // the next larger float, which is certainly not less
  }

  [[nodiscard]] std::size_t slot() const { return bits & 0xFFFFFFFFU; }
  [[nodiscard]] double inverse_depth_max() const {
    return static_cast<double>(std::bit_cast<float>(~static_cast<std::uint32_t>(bits >> 32U)));
  }
  auto operator<=>(const CellEntry&) const = default;
};

/// Square cells over the part of a picture that a mesh covers.
class CellGrid {
 public:
  /// A range of cells, ends included.
  struct Range {
    std::array<std::int32_t, 2> first, last;
  };

  /// Makes half a cell for each face, as if the faces were spread evenly; fewer where they lie in more than
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
    const double least = std::max(2 * across * down, extent.area / 8) / count;  // px²
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

  /// The cell of a point; size() if there is none.
  [[nodiscard]] std::size_t cell_of(double column, double row) const {
    const double x = (column - origin_[0]) * cells_per_px_, y = (row - origin_[1]) * cells_per_px_;
    if (!(x >= 0 && y >= 0 && x < columns_ && y < rows_)) return size();
    return index(static_cast<std::int32_t>(x), static_cast<std::int32_t>(y));
  }

  /// The cells that a box touches; for a box beside all cells the nearest ones.
  [[nodiscard]] Range cells_of(const std::array<double, 2>& low, const std::array<double, 2>& high) const {
    const auto cell = [&](double value, std::size_t axis, std::int32_t count) {
      const double place = (value - origin_[axis]) * cells_per_px_;
      return static_cast<std::int32_t>(std::clamp(place, 0.0, static_cast<double>(count - 1)));
    };
    return {{cell(low[0], 0, columns_), cell(low[1], 1, rows_)},
            {cell(high[0], 0, columns_), cell(high[1], 1, rows_)}};
  }

  /// Calls visit(index) for the cells that a line touches, made wider by `pad` px, some more than once.
  template <class Visit>
  void for_each_cell_along(const std::array<double, 2>& from, const std::array<double, 2>& to, double pad,
                           Visit visit) const {
    const double length = std::max(std::abs(to[0] - from[0]), std::abs(to[1] - from[1]));
    const double count = std::ceil(length * cells_per_px_);
    std::array<double, 2> begin = from;
    for (double i = 1; i <= std::max(count, 1.0); ++i) {
      std::array<double, 2> end = to;
      if (i < count)
        for (std::size_t axis = 0; axis < 2; ++axis)
          end[axis] = from[axis] + (to[axis] - from[axis]) * i / count;
      const Range range = cells_of({std::min(begin[0], end[0]) - pad, std::min(begin[1], end[1]) - pad},
                                   {std::max(begin[0], end[0]) + pad, std::max(begin[1], end[1]) + pad});
      for (std::int32_t y = range.first[1]; y <= range.last[1]; ++y)
        for (std::int32_t x = range.first[0]; x <= range.last[0]; ++x) visit(index(x, y));
      begin = end;
    }
  }

 private:
  std::array<double, 2> origin_{0, 0};
  double side_ = 1;
  double cells_per_px_ = 1;
  std::int32_t columns_ = 1;
  std::int32_t rows_ = 1;
};

}  // namespace tapestry::raster

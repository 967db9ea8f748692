#pragma once
#include <algorithm>
#include <cstddef>
#include <tapestry/core/parallel.hpp>

namespace tapestry::nn {

/// A rectangle of pixels of a picture or of an activation, half-open along both axes.
struct Window {
  BlockRange rows{0, 0};
  BlockRange columns{0, 0};

  [[nodiscard]] bool operator==(const Window& other) const {
    return rows.begin == other.rows.begin && rows.end == other.rows.end &&
           columns.begin == other.columns.begin && columns.end == other.columns.end;
  }

  [[nodiscard]] std::size_t height() const { return rows.end - rows.begin; }
  [[nodiscard]] std::size_t width() const { return columns.end - columns.begin; }
  [[nodiscard]] bool is_empty() const { return rows.begin >= rows.end || columns.begin >= columns.end; }
  [[nodiscard]] bool covers(std::size_t all_rows, std::size_t all_columns) const {
    return rows.begin == 0 && columns.begin == 0 && rows.end >= all_rows && columns.end >= all_columns;
  }
};

/// The smallest range that holds both; an empty one counts for nothing.
[[nodiscard]] constexpr BlockRange hull(BlockRange a, BlockRange b) {
  if (a.begin >= a.end) return b;
  if (b.begin >= b.end) return a;
  return {std::min(a.begin, b.begin), std::max(a.end, b.end)};
}
/// Likewise along both axes.
[[nodiscard]] inline Window hull(const Window& a, const Window& b) {
  if (a.is_empty()) return b;
  if (b.is_empty()) return a;
  return {hull(a.rows, b.rows), hull(a.columns, b.columns)};
}

/// A range grown until it begins at a multiple of `step` and ends at one or at `extent`.
[[nodiscard]] constexpr BlockRange aligned(BlockRange range, std::size_t step, std::size_t extent) {
  return {range.begin / step * step, std::min(extent, block_count(range.end, step) * step)};
}

/// A window of a map of so many rows and columns that is not empty: what is empty becomes one pixel.
[[nodiscard]] inline Window at_least_a_pixel(const Window& window, std::size_t rows, std::size_t columns) {
  const auto grown = [](BlockRange range, std::size_t extent) {
    const std::size_t first = std::min(range.begin, extent - 1);
    return BlockRange{first, std::max(range.end, first + 1)};
  };
  return {grown(window.rows, rows), grown(window.columns, columns)};
}

/// The pixels of a map that blocks within a window of blocks are made of, and the blocks that a window of
/// pixels touches; a block has `rows` times `columns` pixels.
[[nodiscard]] constexpr Window pixels_of_blocks(const Window& blocks, std::size_t rows, std::size_t columns) {
  return {{blocks.rows.begin * rows, blocks.rows.end * rows},
          {blocks.columns.begin * columns, blocks.columns.end * columns}};
}
[[nodiscard]] constexpr Window blocks_of_pixels(const Window& pixels, std::size_t rows, std::size_t columns) {
  return {{pixels.rows.begin / rows, block_count(pixels.rows.end, rows)},
          {pixels.columns.begin / columns, block_count(pixels.columns.end, columns)}};
}

}  // namespace tapestry::nn

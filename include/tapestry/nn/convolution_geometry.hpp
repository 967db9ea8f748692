#pragma once
#include <numeric>
#include <tapestry/core/parallel.hpp>

namespace tapestry::nn {
/// A rectangle of pixels of a picture or of an activation, half-open along both axes.
struct MapWindow {
  BlockRange rows{0, 0};
  BlockRange columns{0, 0};

  [[nodiscard]] bool operator==(const MapWindow& other) const {
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

/// The smallest range that holds both. An empty range does not count.
[[nodiscard]] constexpr BlockRange hull(BlockRange a, BlockRange b) {
  if (a.begin >= a.end) return b;
  if (b.begin >= b.end) return a;
  return {std::min(a.begin, b.begin), std::max(a.end, b.end)};
}
/// Likewise along both axes.
[[nodiscard]] inline MapWindow hull(const MapWindow& a, const MapWindow& b) {
  if (a.is_empty()) return b;
  if (b.is_empty()) return a;
  return {hull(a.rows, b.rows), hull(a.columns, b.columns)};
}

/// A range grown to begin at a multiple of `step` and to end at another one or at `extent`.
[[nodiscard]] constexpr BlockRange aligned(BlockRange range, std::size_t step, std::size_t extent) {
  return {range.begin / step * step, std::min(extent, block_count(range.end, step) * step)};
}

/// A window of a map of so many rows and columns that is not empty: an empty range becomes one pixel.
[[nodiscard]] inline MapWindow at_least_a_pixel(const MapWindow& window, std::size_t rows,
                                                std::size_t columns) {
  const auto grown = [](BlockRange range, std::size_t extent) {
    const std::size_t first = std::min(range.begin, extent - 1);
    return BlockRange{first, std::max(range.end, first + 1)};
  };
  return {grown(window.rows, rows), grown(window.columns, columns)};
}

/// The pixels of a map that blocks within a window of blocks are made of, and the blocks that a window of
/// pixels touches; a block has `rows` times `columns` pixels.
[[nodiscard]] constexpr MapWindow pixels_of_blocks(const MapWindow& blocks, std::size_t rows,
                                                   std::size_t columns) {
  return {{blocks.rows.begin * rows, blocks.rows.end * rows},
          {blocks.columns.begin * columns, blocks.columns.end * columns}};
}
[[nodiscard]] constexpr MapWindow blocks_of_pixels(const MapWindow& pixels, std::size_t rows,
                                                   std::size_t columns) {
  return {{pixels.rows.begin / rows, block_count(pixels.rows.end, rows)},
          {pixels.columns.begin / columns, block_count(pixels.columns.end, columns)}};
}

/// How an axis of a convolution maps outputs to inputs: output j reads input j·stride − padding + t·spacing
/// for tap t = 0 … taps − 1, and zero where that lies outside 0 … input − 1.
struct AxisWindow {
  std::size_t input = 1;
  std::size_t output = 1;
  std::size_t taps = 1;
  std::size_t stride = 1;
  std::size_t spacing = 1;
  std::ptrdiff_t padding = 0;  ///< may be negative: the first input read then lies inside

  /// Inputs between the first and the last that `outputs` neighbouring outputs read.
  [[nodiscard]] std::size_t reach(std::size_t outputs) const {
    return (outputs - 1) * stride + (taps - 1) * spacing + 1;
  }
};

/// The part of an axis' adjoint that belongs to every stride-th input, beginning at `first`. It is again a
/// window over the outputs; its tap t uses the forward tap first_tap − t·tap_step.
struct AxisAdjoint {
  std::size_t first = 0;
  std::size_t first_tap = 0;
  std::size_t tap_step = 1;
  AxisWindow window{};
};

/// Input i is read by output j at tap t where i + padding = j·stride + t·spacing. For inputs i ≡ first
/// (mod stride) the taps that solve this repeat with period stride / gcd(stride, spacing).
[[nodiscard]] inline std::vector<AxisAdjoint> adjoint_of(const AxisWindow& axis) {
  const std::size_t common = std::gcd(axis.stride, axis.spacing);
  const auto stride = static_cast<std::ptrdiff_t>(axis.stride);
  std::vector<AxisAdjoint> parts;
  std::vector<std::size_t> taps(std::min(axis.stride, axis.input), 0), last_tap(taps.size(), 0);
  for (std::size_t t = 0; t < axis.taps; ++t) {
    const auto place = (static_cast<std::ptrdiff_t>(t * axis.spacing) - axis.padding) % stride;
    const auto first = static_cast<std::size_t>(place < 0 ? place + stride : place);
    if (first >= taps.size()) continue;
    ++taps[first];
    last_tap[first] = t;
  }
  for (std::size_t first = 0; first < taps.size(); ++first) {
    if (taps[first] == 0) continue;
    AxisAdjoint part;
    part.first = first;
    part.first_tap = last_tap[first];
    part.tap_step = axis.stride / common;
    part.window.input = axis.output;
    part.window.output = (axis.input - first + axis.stride - 1) / axis.stride;
    part.window.taps = taps[first];
    part.window.spacing = axis.spacing / common;
    part.window.padding = -(static_cast<std::ptrdiff_t>(first) + axis.padding -
                            static_cast<std::ptrdiff_t>(part.first_tap * axis.spacing)) /
                          stride;
    parts.push_back(part);
  }
  return parts;
}

/// A convolution over activations stored as [row, column, channel].
struct ConvolutionShape {
  AxisWindow rows{};
  AxisWindow columns{};
  std::size_t in_channels = 1;   ///< of all groups together
  std::size_t out_channels = 1;  ///< of all groups together
  std::size_t groups = 1;

  [[nodiscard]] bool is_depthwise() const {
    return groups > 1 && groups == in_channels && groups == out_channels;
  }
  [[nodiscard]] std::size_t group_in() const { return in_channels / groups; }
  [[nodiscard]] std::size_t group_out() const { return out_channels / groups; }
  [[nodiscard]] std::size_t taps() const { return rows.taps * columns.taps; }
  [[nodiscard]] std::size_t in_size() const { return rows.input * columns.input * in_channels; }
  [[nodiscard]] std::size_t out_size() const { return rows.output * columns.output * out_channels; }
  [[nodiscard]] std::size_t weight_count() const { return out_channels * group_in() * taps(); }
};

/// Square filter of `size` taps with the same stride, dilation and zero padding on both axes.
[[nodiscard]] inline ConvolutionShape square_convolution(std::size_t height, std::size_t width,
                                                         std::size_t in_channels, std::size_t out_channels,
                                                         std::size_t size, std::size_t stride,
                                                         std::size_t padding, std::size_t dilation = 1,
                                                         std::size_t groups = 1) {
  const auto axis = [&](std::size_t input) {
    const std::size_t output = (input + 2 * padding - ((size - 1) * dilation + 1)) / stride + 1;
    return AxisWindow{input, output, size, stride, dilation, static_cast<std::ptrdiff_t>(padding)};
  };
  return {axis(height), axis(width), in_channels, out_channels, groups};
}
}  // namespace tapestry::nn

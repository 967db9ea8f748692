#pragma once
#include <tapestry/nn/convolution_geometry.hpp>
#include <tapestry/nn/workspace.hpp>

namespace tapestry::nn::detail {
/// The inputs of some output rows, all inside memory: either the picture itself or a copy with its zeros.
template <std::floating_point T>
struct ConvolutionRegion {
  const T* first;  ///< input of output (first row, column 0) at tap (0, 0), channel 0
  std::size_t row_step;
  std::size_t pixel_step;
};

/// True if no output reads outside the picture.
[[nodiscard]] inline bool reads_only_inside(const ConvolutionShape& shape) {
  const auto inside = [](const AxisWindow& axis) {
    return axis.padding <= 0 &&
           axis.reach(axis.output) + static_cast<std::size_t>(-axis.padding) <= axis.input;
  };
  return inside(shape.rows) && inside(shape.columns);
}

/// Pixels that a copied region has between neighbours in memory: the channels, and one cache line more
/// where rows of whole pages would fall into the same cache set.
template <std::floating_point T>
[[nodiscard]] std::size_t copied_pixel_step(std::size_t channels) {
  return channels * sizeof(T) % 1024 == 0 ? channels + 64 / sizeof(T) : channels;
}

/// Copies the inputs of `row_count` output rows from `first_row` on, with zeros outside.
template <std::floating_point T>
[[nodiscard]] ConvolutionRegion<T> copy_region(const ConvolutionShape& shape, const T* picture,
                                               std::size_t first_row, std::size_t row_count,
                                               Buffer<T>& scratch) {
  const std::size_t channels = shape.in_channels;
  const std::size_t pixel_step = copied_pixel_step<T>(channels);
  const std::size_t height = shape.rows.reach(row_count);
  const std::size_t width = shape.columns.reach(shape.columns.output);
  scratch.resize(height * width * pixel_step);
  const auto in_rows = static_cast<std::ptrdiff_t>(shape.rows.input);
  const auto in_columns = static_cast<std::ptrdiff_t>(shape.columns.input);
  const std::ptrdiff_t top = static_cast<std::ptrdiff_t>(first_row * shape.rows.stride) - shape.rows.padding;
  const std::ptrdiff_t left = -shape.columns.padding;
  const auto extent = static_cast<std::ptrdiff_t>(width);
  const std::ptrdiff_t begin =
      std::clamp(-left, std::ptrdiff_t(0), extent);  // region columns inside the picture
  const std::ptrdiff_t end = std::clamp(in_columns - left, begin, extent);
  for (std::size_t r = 0; r < height; ++r) {
    T* const row = scratch.data() + r * width * pixel_step;
    const std::ptrdiff_t y = top + static_cast<std::ptrdiff_t>(r);
    const bool is_outside = y < 0 || y >= in_rows;
    const std::ptrdiff_t from = is_outside ? extent : begin;
    const std::ptrdiff_t to = is_outside ? extent : end;
    const auto at = [&](std::ptrdiff_t x) { return row + static_cast<std::size_t>(x) * pixel_step; };
    std::fill(row, at(from), T(0));
    if (from < to) {
      const T* source = picture + static_cast<std::size_t>(y * in_columns + left + from) * channels;
      if (pixel_step == channels) {
        std::memcpy(at(from), source, static_cast<std::size_t>(to - from) * channels * sizeof(T));
      } else {
        for (std::ptrdiff_t x = from; x < to; ++x, source += channels)
          std::memcpy(at(x), source, channels * sizeof(T));
      }
    }
    std::fill(at(to), at(extent), T(0));
  }
  return {scratch.data(), width * pixel_step, pixel_step};
}

/// The region without a copy, for a convolution that reads only inside the picture.
template <std::floating_point T>
[[nodiscard]] ConvolutionRegion<T> direct_region(const ConvolutionShape& shape, const T* picture,
                                                 std::size_t first_row) {
  const std::size_t row_step = shape.columns.input * shape.in_channels;
  const auto top = static_cast<std::size_t>(static_cast<std::ptrdiff_t>(first_row * shape.rows.stride) -
                                            shape.rows.padding);
  const auto left = static_cast<std::size_t>(-shape.columns.padding);
  return {picture + top * row_step + left * shape.in_channels, row_step, shape.in_channels};
}

/// A piece of the reduction over taps and channels, short enough for accurate sums and the first cache.
struct ReductionBlock {
  std::size_t in_offset;     ///< from a pixel's origin in its region
  std::size_t weight_first;  ///< position in the reduction
  std::size_t outer_count;
  std::size_t outer_step;
  std::size_t inner_count;
};

/// Longest run of products that is summed in registers before it is added to memory.
inline constexpr std::size_t longest_reduction = 256;

/// Cuts the reduction of a group into blocks, in the order of the packed weights.
[[nodiscard]] inline std::vector<ReductionBlock> reduction_blocks(const ConvolutionShape& shape,
                                                                  std::size_t row_step,
                                                                  std::size_t pixel_step) {
  const std::size_t channels = shape.group_in();
  const bool merges = pixel_step == channels && shape.columns.spacing == 1;  // taps of a row touch in memory
  const std::size_t run = merges ? channels * shape.columns.taps : channels;
  const std::size_t runs_of_row = merges ? 1 : shape.columns.taps;
  const std::size_t tap_step = shape.columns.spacing * pixel_step;
  std::vector<ReductionBlock> blocks;
  for (std::size_t y = 0; y < shape.rows.taps; ++y) {
    const std::size_t row_offset = y * shape.rows.spacing * row_step;
    const std::size_t row_first = y * shape.columns.taps * channels;
    if (run > longest_reduction) {
      const std::size_t pieces = (run + longest_reduction - 1) / longest_reduction;
      for (std::size_t r = 0; r < runs_of_row; ++r)
        for (std::size_t p = 0; p < pieces; ++p) {
          const std::size_t begin = run * p / pieces;
          blocks.push_back({row_offset + r * tap_step + begin, row_first + r * run + begin, 1, 0,
                            run * (p + 1) / pieces - begin});
        }
      continue;
    }
    const std::size_t most = longest_reduction / run;
    if (merges) {
      const std::size_t rows_left = shape.rows.taps - y;
      const std::size_t count = std::min(most, rows_left);
      blocks.push_back({row_offset, row_first, count, shape.rows.spacing * row_step, run});
      y += count - 1;
      continue;
    }
    for (std::size_t r = 0; r < runs_of_row; r += most)
      blocks.push_back(
          {row_offset + r * tap_step, row_first + r * run, std::min(most, runs_of_row - r), tap_step, run});
  }
  return blocks;
}
}  // namespace tapestry::nn::detail

#pragma once
#include <tapestry/nn/detail/packed_convolution.hpp>

namespace tapestry::nn {
/// True if Winograd's algorithm in this form computes this convolution: one group, taps side by side, and the
/// form's taps and stride along both axes.
template <std::floating_point T>
[[nodiscard]] bool has_form(const PackedConvolution<T>& packed, WinogradForm form) {
  const auto fits = [&](const AxisWindow& axis) {
    return axis.taps == extents_of(form).taps && axis.stride == 1 && axis.spacing == 1;
  };
  return fits(packed.shape.rows) && fits(packed.shape.columns) && packed.shape.groups == 1;
}

namespace detail {
/// How one convolution is cut up; depends on its extents alone.
struct WinogradPlan {
  WinogradForm form = WinogradForm::f4_taps3;
  WinogradExtents axis = extents_of(form);
  std::size_t products = 36;  ///< products for a tile and a pair of channels
  std::size_t tile_rows = 0, tile_columns = 0;
  std::size_t tiles = 0;            ///< tiles of all images
  std::size_t tiles_per_range = 0;  ///< tiles that share transformed filters
  std::size_t ranges = 0;
  std::size_t channels_per_block = 0;  ///< channels of a partial sum; whole vectors
  std::size_t channels_per_word = 1;   ///< 2 where words hold pairs
  std::size_t words_per_block = 0;
  std::size_t blocks = 0;
  std::size_t panels = 0;
  /// Whether tasks share filters. If so, the transformed filters of all panels are computed first, and each
  /// task transforms the inputs of its range and multiplies them with all filters. If not, all inputs are
  /// transformed first, and each task transforms the filters of its panel. Sharing writes less to memory
  /// where there are few filters.
  bool shares_filters = false;
  /// Whether transformed filters are kept from pass to pass: if they are few, reading them is faster.
  bool keeps_filters = false;

  // Distances in memory, a cache line longer than needed so that points do not fall into one cache set.
  [[nodiscard]] std::size_t input_point_step(std::size_t line) const {
    return tiles_per_range * words_per_block + line;
  }
  [[nodiscard]] std::size_t input_block_step(std::size_t line) const {
    return products * input_point_step(line);
  }
  [[nodiscard]] std::size_t input_range_step(std::size_t line) const {
    return blocks * input_block_step(line);
  }
  [[nodiscard]] std::size_t filter_point_step(std::size_t line, std::size_t width) const {
    return words_per_block * width + line;
  }
};

template <std::floating_point T>
[[nodiscard]] WinogradPlan plan_winograd(const ConvolutionShape& shape, std::size_t images, WinogradForm form,
                                         bool pairs = false) {
  const std::size_t lanes = kernels<T>().lanes;
  WinogradPlan plan;
  plan.form = form;
  plan.axis = extents_of(form);
  plan.products = plan.axis.points * plan.axis.points;
  plan.tile_rows = block_count(shape.rows.output, plan.axis.outputs);
  plan.tile_columns = block_count(shape.columns.output, plan.axis.outputs);
  plan.tiles = images * plan.tile_rows * plan.tile_columns;
  plan.panels = block_count(shape.out_channels, 2 * lanes);
  plan.channels_per_word = pairs ? 2 : 1;
  plan.blocks = block_count(shape.in_channels, 64 * plan.channels_per_word);
  // With pairs, blocks are the same on every instruction set, and so is the order of the sums.
  plan.channels_per_block = round_up(block_count(shape.in_channels, plan.blocks), pairs ? 32 : lanes);
  plan.words_per_block = plan.channels_per_block / plan.channels_per_word;
  plan.blocks = block_count(shape.in_channels, plan.channels_per_block);
  // Sums of a range, filters of a block and, where filters are shared, inputs of a range stay in the second
  // cache.
  constexpr std::size_t sum_bytes = 480 * 1024;
  constexpr std::size_t range_bytes = 640 * 1024;
  constexpr std::size_t shared_filter_bytes = 1440 * 1024;
  const std::size_t bytes_of_tile = plan.products * 2 * lanes * sizeof(T);
  const std::size_t words = shape.in_channels / plan.channels_per_word;
  const std::size_t bytes_with_input = bytes_of_tile + plan.products * words * sizeof(T);
  const std::size_t filter_bytes = plan.products * words * round_up(shape.out_channels, lanes) * sizeof(T);
  const std::size_t fitting = range_bytes / bytes_with_input;
  constexpr std::size_t kept_filter_bytes = 1024 * 1024;
  plan.keeps_filters = filter_bytes <= kept_filter_bytes;
  plan.shares_filters = filter_bytes <= shared_filter_bytes && fitting >= 12 && plan.tiles >= 8 * fitting;
  const std::size_t most =
      plan.shares_filters ? fitting : std::max<std::size_t>(8, sum_bytes / bytes_of_tile);
  plan.ranges = block_count(plan.tiles, most);
  plan.tiles_per_range = block_count(plan.tiles, plan.ranges);
  plan.ranges = block_count(plan.tiles, plan.tiles_per_range);
  return plan;
}
}  // namespace detail
}  // namespace tapestry::nn

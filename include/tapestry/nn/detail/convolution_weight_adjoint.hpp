#pragma once
#include <tapestry/nn/detail/convolution.hpp>

namespace tapestry::nn {
namespace detail {
/// How the sum over images and rows is cut: `groups` partial sums of consecutive units, added in order.
struct WeightAdjointPlan {
  std::size_t rows_per_unit = 1;
  std::size_t units_of_image = 1;
  std::size_t units = 1;
  std::size_t groups = 1;
  std::size_t units_per_group = 1;
  std::size_t panel_splits = 1;  ///< tasks that share the units of a group, each with panels of its own
  std::size_t layout_size = 0;   ///< values of one partial sum
};

template <std::floating_point T>
[[nodiscard]] WeightAdjointPlan plan_weight_adjoint(const ConvolutionShape& shape, std::size_t images) {
  WeightAdjointPlan plan;
  const std::size_t lanes = kernels<T>().lanes;
  const std::size_t padded = round_up(shape.group_out(), lanes);
  plan.layout_size = shape.is_depthwise() ? shape.taps() * round_up(shape.groups, lanes)
                                          : shape.groups * padded * shape.group_in() * shape.taps();
  const std::size_t row_bytes = shape.columns.input * shape.rows.stride * shape.in_channels * sizeof(T);
  const std::size_t fitting = std::max<std::size_t>(1, region_bytes / std::max<std::size_t>(1, row_bytes));
  const std::size_t halo = (shape.rows.taps - 1) * shape.rows.spacing / shape.rows.stride;
  plan.rows_per_unit = std::clamp<std::size_t>(fitting > halo ? fitting - halo : 1, 1, shape.rows.output);
  plan.units_of_image = block_count(shape.rows.output, plan.rows_per_unit);
  plan.units = images * plan.units_of_image;
  constexpr std::size_t partial_bytes = std::size_t(32) << 20U;  // for all partial sums together
  const std::size_t affordable = std::max<std::size_t>(1, partial_bytes / (plan.layout_size * sizeof(T)));
  plan.groups = std::min({std::size_t(8), plan.units, affordable});
  plan.units_per_group = block_count(plan.units, plan.groups);
  plan.groups = block_count(plan.units, plan.units_per_group);
  const std::size_t panels =
      shape.is_depthwise() ? 1 : shape.groups * block_count(shape.group_out(), 2 * lanes);
  plan.panel_splits = std::min(panels, block_count(8, plan.groups));
  return plan;
}

/// Copies the output adjoint of some rows into [pixel, lane] with zeros in the missing lanes.
template <std::floating_point T>
void pack_adjoint_panel(const T* adjoint, std::size_t pixels, std::size_t channels, std::size_t first_channel,
                        std::size_t count, std::size_t width, Buffer<T>& panel) {
  panel.resize(pixels * width);
  for (std::size_t p = 0; p < pixels; ++p) {
    const T* from = adjoint + p * channels + first_channel;
    T* to = panel.data() + p * width;
    std::copy(from, from + count, to);
    std::fill(to + count, to + width, T(0));
  }
}

/// Adds one panel's part of a unit: sum[k, lane] += Σ_pixels in[pixel, k] · panel[pixel, lane].
template <std::floating_point T>
void add_weight_panel(const ConvolutionShape& shape, const ConvolutionRegion<T>& region,
                      std::size_t row_count, std::size_t group, std::size_t width, const T* panel, T* sum) {
  const Kernels<T>& simd = kernels<T>();
  const std::size_t columns = shape.columns.output;
  const std::size_t rows_at_once = std::max<std::size_t>(1, longest_reduction / columns);
  const bool merges = region.pixel_step == shape.group_in() && shape.columns.spacing == 1;
  const std::size_t run = merges ? shape.group_in() * shape.columns.taps : shape.group_in();
  const std::size_t runs = merges ? 1 : shape.columns.taps;
  ReduceArguments<T> tile{};
  tile.in_row_step = 1;
  tile.in_inner_step = static_cast<std::ptrdiff_t>(shape.columns.stride * region.pixel_step);
  tile.in_outer_step = static_cast<std::ptrdiff_t>(shape.rows.stride * region.row_step);
  tile.inner_count = columns;
  tile.out_row_step = static_cast<std::ptrdiff_t>(width);
  tile.lane_count = width;
  tile.end.adds = true;
  for (std::size_t row = 0; row < row_count; row += rows_at_once) {
    tile.outer_count = std::min(rows_at_once, row_count - row);
    tile.weights = panel + row * columns * width;
    for (std::size_t y = 0; y < shape.rows.taps; ++y)
      for (std::size_t r = 0; r < runs; ++r) {
        const T* in = region.first + (row * shape.rows.stride + y * shape.rows.spacing) * region.row_step +
                      r * shape.columns.spacing * region.pixel_step + group * shape.group_in();
        T* out = sum + (y * shape.columns.taps * shape.group_in() + r * run) * width;
        const std::size_t tiles = block_count(run, simd.tile_rows);
        for (std::size_t t = 0; t < tiles; ++t) {
          const std::size_t begin = run * t / tiles;
          const std::size_t height = run * (t + 1) / tiles - begin;
          tile.in = in + begin;
          tile.out = out + begin * width;
          simd.reduce[width / simd.lanes - 1][height - 1](tile);
        }
      }
  }
}

/// Adds the depthwise part of a unit.
template <std::floating_point T>
void add_depthwise_weights(const ConvolutionShape& shape, const ConvolutionRegion<T>& region,
                           std::size_t row_count, const T* adjoint, T* sum) {
  std::vector<std::ptrdiff_t> offsets;
  for (std::size_t y = 0; y < shape.rows.taps; ++y)
    for (std::size_t x = 0; x < shape.columns.taps; ++x)
      offsets.push_back(static_cast<std::ptrdiff_t>(y * shape.rows.spacing * region.row_step +
                                                    x * shape.columns.spacing * region.pixel_step));
  DepthwiseWeightArguments<T> line{};
  line.in_pixel_step = shape.columns.stride * region.pixel_step;
  line.tap_offsets = offsets.data();
  line.tap_count = offsets.size();
  line.pixel_count = shape.columns.output;
  line.channel_count = shape.groups;
  line.weights_adjoint = sum;
  line.weight_step = round_up(shape.groups, kernels<T>().lanes);
  for (std::size_t row = 0; row < row_count; ++row) {
    line.in = region.first + row * shape.rows.stride * region.row_step;
    line.out_adjoint = adjoint + row * shape.columns.output * shape.out_channels;
    kernels<T>().depthwise_weight_adjoint_row(line);
  }
}

/// Adds a partial sum in the packed layout to weights_adjoint, [filter, channel, row tap, column tap].
template <std::floating_point T>
void unpack_weights(const ConvolutionShape& shape, const T* sum, T* weights_adjoint) {
  const std::size_t lanes = kernels<T>().lanes;
  const std::size_t taps = shape.taps();
  if (shape.is_depthwise()) {
    const std::size_t pitch = round_up(shape.groups, lanes);
    for (std::size_t g = 0; g < shape.groups; ++g)
      for (std::size_t t = 0; t < taps; ++t) weights_adjoint[g * taps + t] += sum[t * pitch + g];
    return;
  }
  const std::size_t padded = round_up(shape.group_out(), lanes);
  const std::size_t panels = block_count(padded, 2 * lanes);
  const std::size_t channels = shape.group_in();
  parallel_for(shape.groups * panels, [&](std::size_t task) {
    const std::size_t g = task / panels;
    const std::size_t first = task % panels * 2 * lanes;
    const std::size_t width = panel_lanes(first, padded, lanes);
    const std::size_t count = std::min(width, shape.group_out() - first);
    const T* panel = sum + (g * padded + first) * taps * channels;
    for (std::size_t i = 0; i < channels; ++i)
      for (std::size_t lane = 0; lane < count; ++lane) {
        T* const to = weights_adjoint + ((g * shape.group_out() + first + lane) * channels + i) * taps;
        for (std::size_t t = 0; t < taps; ++t) to[t] += panel[(t * channels + i) * width + lane];
      }
  });
}

/// One unit, some rows of one image, for the panels of one task.
template <std::floating_point T>
void add_unit(const ConvolutionShape& shape, const WeightAdjointPlan& plan, const T* in, const T* out_adjoint,
              std::size_t unit, std::size_t split, T* sum) {
  static thread_local Buffer<T> scratch;
  static thread_local Buffer<T> panel;
  const std::size_t image = unit / plan.units_of_image;
  const BlockRange rows = block_range(unit % plan.units_of_image, shape.rows.output, plan.rows_per_unit);
  const std::size_t row_count = rows.end - rows.begin;
  const T* picture = in + image * shape.in_size();
  const T* adjoint =
      out_adjoint + image * shape.out_size() + rows.begin * shape.columns.output * shape.out_channels;
  const ConvolutionRegion<T> region = reads_only_inside(shape)
                                          ? direct_region(shape, picture, rows.begin)
                                          : copy_region(shape, picture, rows.begin, row_count, scratch);
  if (shape.is_depthwise()) return add_depthwise_weights(shape, region, row_count, adjoint, sum);
  const std::size_t lanes = kernels<T>().lanes;
  const std::size_t padded = round_up(shape.group_out(), lanes);
  const std::size_t reduction = shape.taps() * shape.group_in();
  std::size_t index = 0;
  for (std::size_t g = 0; g < shape.groups; ++g)
    for (std::size_t first = 0; first < padded; first += panel_lanes(first, padded, lanes), ++index) {
      if (index % plan.panel_splits != split) continue;
      const std::size_t width = panel_lanes(first, padded, lanes);
      pack_adjoint_panel(adjoint, row_count * shape.columns.output, shape.out_channels,
                         g * shape.group_out() + first, std::min(width, shape.group_out() - first), width,
                         panel);
      add_weight_panel(shape, region, row_count, g, width, panel.data(),
                       sum + (g * padded + first) * reduction);
    }
}
}  // namespace detail

/// Adds Σ_n,y,x in[n, …] · out_adjoint[n, y, x, m] to weights_adjoint, the gradient of a convolution with
/// respect to its weights, [filter, channel of its group, row tap, column tap].
///
/// \param in           [images, row, column, channel], readable 128 bytes past its end
/// \param out_adjoint  [images, row, column, filter], readable 128 bytes past its end
/// \param partial      scratch that may be kept between calls
///
/// Images and rows are summed in an order that depends on the extents alone.
template <std::floating_point T>
void convolution_weight_adjoint(const ConvolutionShape& shape, std::size_t images, const T* in,
                                const T* out_adjoint, Buffer<T>& partial, T* weights_adjoint) {
  const auto plan = detail::plan_weight_adjoint<T>(shape, images);
  partial.resize(plan.groups * plan.layout_size);
  partial.fill_zero();
  parallel_for(plan.groups * plan.panel_splits, [&](std::size_t task) {
    const std::size_t group = task / plan.panel_splits;
    const BlockRange units = block_range(group, plan.units, plan.units_per_group);
    for (std::size_t unit = units.begin; unit < units.end; ++unit)
      detail::add_unit(shape, plan, in, out_adjoint, unit, task % plan.panel_splits,
                       partial.data() + group * plan.layout_size);
  });
  for (std::size_t group = 1; group < plan.groups; ++group)
    kernels<T>().add(partial.data() + group * plan.layout_size, partial.data(), plan.layout_size);
  detail::unpack_weights(shape, partial.data(), weights_adjoint);
}
}  // namespace tapestry::nn

#pragma once
#include <tapestry/nn/detail/depthwise_convolution.hpp>

namespace tapestry::nn {
namespace detail {
/// How the output of one image is cut into tasks, which does not depend on the number of threads.
struct ConvolutionTasks {
  bool copies = true;         ///< inputs are copied, with zeros around them
  std::size_t row_count = 0;  ///< output rows, or runs of pixels where rows do not matter
  std::size_t row_width = 0;  ///< pixels of a row; the last run of pixels may be shorter
  std::size_t pixel_count = 0;
  std::size_t rows_per_task = 1;
  std::size_t row_tasks = 1;
  std::size_t panels = 1;  ///< panels of all groups together
  std::size_t panels_per_task = 1;
  std::size_t panel_tasks = 1;
};

/// Bytes of a copied region that stay in the second cache beside weights and outputs.
inline constexpr std::size_t region_bytes = 384 * 1024;

template <std::floating_point T>
[[nodiscard]] ConvolutionTasks plan_tasks(const PackedConvolution<T>& packed, std::size_t images) {
  const ConvolutionShape& shape = packed.shape;
  ConvolutionTasks tasks;
  tasks.copies = packed.copies_inputs;
  tasks.pixel_count = shape.rows.output * shape.columns.output;
  const bool is_dense =
      packed.row_step == 1 && packed.column_step == 1 && shape.columns.output == packed.out_columns;
  const bool is_pointwise = !tasks.copies && is_dense && shape.taps() == 1 && shape.rows.stride == 1 &&
                            shape.columns.stride == 1 && shape.columns.input == shape.columns.output &&
                            shape.rows.padding == 0;
  tasks.row_width = is_pointwise ? 96 : shape.columns.output;
  tasks.row_count = (tasks.pixel_count + tasks.row_width - 1) / tasks.row_width;
  const std::size_t lanes = kernels<T>().lanes;
  tasks.panels = shape.groups * block_count(shape.group_out(), 2 * lanes);

  const std::size_t row_bytes =
      std::max<std::size_t>(1, (is_pointwise ? tasks.row_width : shape.columns.input * shape.rows.stride) *
                                   shape.in_channels * sizeof(T));
  const std::size_t halo = (shape.rows.taps - 1) * shape.rows.spacing / shape.rows.stride;
  const std::size_t fitting = region_bytes / row_bytes;
  const double work = 2.0 * static_cast<double>(packed.reduction() * shape.out_channels) *
                      static_cast<double>(tasks.pixel_count);
  const std::size_t useful = useful_tasks(work);
  const std::size_t wanted = std::max<std::size_t>(1, useful / std::max<std::size_t>(1, images));
  tasks.rows_per_task = std::clamp<std::size_t>(fitting > halo ? fitting - halo : 1, 1, tasks.row_count);
  const std::size_t fewest_rows = std::min(tasks.row_count, std::max<std::size_t>(4, 4 * halo));
  const std::size_t balanced = std::max(fewest_rows, (tasks.row_count + wanted - 1) / wanted);
  tasks.rows_per_task = std::min(tasks.rows_per_task, balanced);
  tasks.row_tasks = block_count(tasks.row_count, tasks.rows_per_task);
  tasks.rows_per_task = block_count(tasks.row_count, tasks.row_tasks);  // even them out
  tasks.row_tasks = block_count(tasks.row_count, tasks.rows_per_task);
  const std::size_t panel_tasks = std::clamp<std::size_t>(wanted / tasks.row_tasks, 1, tasks.panels);
  tasks.panels_per_task = block_count(tasks.panels, panel_tasks);
  tasks.panel_tasks = block_count(tasks.panels, tasks.panels_per_task);
  return tasks;
}

/// One convolution of one image, within one task.
template <std::floating_point T>
struct ConvolutionRows {
  const PackedConvolution<T>& packed;
  const ConvolutionTasks& tasks;
  ConvolutionRegion<T> region;
  std::size_t first_row;
  std::size_t end_row;
  T* out;  ///< the whole output picture
  Epilogue<T> end;

  [[nodiscard]] std::size_t width_of(std::size_t row) const {
    return std::min(tasks.row_width, tasks.pixel_count - row * tasks.row_width);
  }
  [[nodiscard]] const T* in_row(std::size_t row) const {
    return region.first + (row - first_row) * packed.shape.rows.stride * region.row_step;
  }
  [[nodiscard]] T* out_row(std::size_t row) const {
    if (tasks.row_width != packed.shape.columns.output)
      return out + row * tasks.row_width * packed.shape.out_channels;
    const std::size_t y = packed.first_row + row * packed.row_step;
    return out + (y * packed.out_columns + packed.first_column) * packed.shape.out_channels;
  }
};

/// One reduction block of one panel for one row of pixels.
template <std::floating_point T>
void reduce_row(const ConvolutionRows<T>& rows, std::size_t row, const ReductionBlock& block,
                ReduceArguments<T>& tile, std::size_t registers, std::size_t in_channel,
                std::size_t out_channel) {
  const Kernels<T>& simd = kernels<T>();
  const std::size_t width = rows.width_of(row);
  const std::size_t tile_count = (width + simd.tile_rows - 1) / simd.tile_rows;
  const T* in = rows.in_row(row) + block.in_offset + in_channel;
  T* out = rows.out_row(row) + out_channel;
  for (std::size_t t = 0; t < tile_count; ++t) {
    const std::size_t height = width * (t + 1) / tile_count - width * t / tile_count;
    tile.in = in;
    tile.out = out;
    (rows.packed.holds_pairs ? simd.reduce_pairs : simd.reduce)[registers - 1][height - 1](tile);
    in += static_cast<std::ptrdiff_t>(height) * tile.in_row_step;
    out += static_cast<std::ptrdiff_t>(height) * tile.out_row_step;
  }
}

/// Applies the whole epilogue, bias and addition included, to the last of several partial sums.
template <std::floating_point T>
void finish(const Epilogue<T>& whole, Epilogue<T>& last) {
  const T* const bias = last.bias;
  const bool adds = last.adds;
  last = whole;
  last.bias = bias;
  last.adds = adds;
}

template <std::floating_point T>
void convolve_panel(const ConvolutionRows<T>& rows, const std::vector<ReductionBlock>& blocks,
                    std::size_t panel) {
  const ConvolutionShape& shape = rows.packed.shape;
  const std::size_t lanes = kernels<T>().lanes;
  const std::size_t panels_of_group = rows.tasks.panels / shape.groups;
  const std::size_t group = panel / panels_of_group;
  const std::size_t first = panel % panels_of_group * 2 * lanes;
  const std::size_t padded = round_up(shape.group_out(), lanes);
  const std::size_t width = panel_lanes(first, padded, lanes);
  const T* weights = rows.packed.weights->data() + (group * padded + first) * rows.packed.reduction();
  const std::size_t out_channel = group * shape.group_out() + first;
  ReduceArguments<T> tile{};
  tile.in_row_step = static_cast<std::ptrdiff_t>(shape.columns.stride * rows.region.pixel_step);
  tile.in_inner_step = 1;
  tile.out_row_step = static_cast<std::ptrdiff_t>(rows.packed.column_step * shape.out_channels);
  tile.lane_count = std::min(width, shape.group_out() - first);
  for (std::size_t b = 0; b < blocks.size(); ++b) {
    tile.weights = weights + blocks[b].weight_first * width;
    tile.in_outer_step = static_cast<std::ptrdiff_t>(blocks[b].outer_step);
    tile.outer_count = blocks[b].outer_count;
    tile.inner_count = blocks[b].inner_count;
    tile.end = {};
    if (b == 0 && rows.end.bias != nullptr) tile.end.bias = rows.end.bias + out_channel;
    tile.end.adds = b > 0 || rows.end.adds;
    if (b + 1 == blocks.size()) finish(rows.end, tile.end);
    for (std::size_t row = rows.first_row; row < rows.end_row; ++row)
      reduce_row(rows, row, blocks[b], tile, width / lanes, group * shape.group_in(), out_channel);
  }
}
}  // namespace detail

/// Applies one packed convolution to a batch.
///
///   out[n, y, x, m] = end(Σ in[n, …, c] · weights)
///
/// \param in   [images, row, column, channel], readable 128 bytes past its end, as a Buffer is
/// \param end  applied to each sum; its bias, one for each channel out, is readable 128 bytes past its end
/// \param out  [images, rows, columns, channel] of image_size values each
///
/// Every output is summed in blocks of at most 256 products whose order depends on the layer alone.
template <std::floating_point T>
void convolve(const PackedConvolution<T>& packed, std::size_t images, const T* in, const Epilogue<T>& end,
              T* out, std::size_t out_image_size) {
  if (packed.shape.is_depthwise()) return convolve_depthwise(packed, images, in, end, out, out_image_size);
  const detail::ConvolutionTasks tasks = detail::plan_tasks(packed, images);
  const std::size_t tasks_of_image = tasks.row_tasks * tasks.panel_tasks;
  const std::size_t in_image_size =
      packed.shape.rows.input * packed.shape.columns.input * packed.shape.in_channels;
  parallel_for(images * tasks_of_image, [&](std::size_t task) {
    static thread_local Buffer<T> scratch;
    const std::size_t image = task / tasks_of_image;
    const BlockRange range =
        block_range(task % tasks_of_image / tasks.panel_tasks, tasks.row_count, tasks.rows_per_task);
    const BlockRange panels = block_range(task % tasks.panel_tasks, tasks.panels, tasks.panels_per_task);
    const T* picture = in + image * in_image_size;
    const bool in_runs = tasks.row_width != packed.shape.columns.output;
    const detail::ConvolutionRegion<T> region =
        tasks.copies
            ? detail::copy_region(packed.shape, picture, range.begin, range.end - range.begin, scratch)
            : detail::direct_region(packed.shape, picture, in_runs ? 0 : range.begin);
    detail::ConvolutionRows<T> rows{
        packed, tasks, region, range.begin, range.end, out + image * out_image_size, end};
    rows.end.origin = out;
    if (in_runs) {  // rows are runs of pixels here, whatever the picture's width
      rows.region.row_step = tasks.row_width * region.pixel_step;
      rows.region.first = picture + range.begin * rows.region.row_step;
    }
    const auto blocks = detail::reduction_blocks(packed.shape, region.row_step, region.pixel_step);
    for (std::size_t panel = panels.begin; panel < panels.end; ++panel)
      detail::convolve_panel(rows, blocks, panel);
  });
}
}  // namespace tapestry::nn

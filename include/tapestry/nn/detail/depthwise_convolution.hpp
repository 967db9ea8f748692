#pragma once
#include <tapestry/nn/detail/packed_convolution.hpp>

namespace tapestry::nn {
namespace detail {
/// Taps of an axis that lie inside for one output.
[[nodiscard]] inline BlockRange inner_taps(const AxisWindow& axis, std::size_t output) {
  const std::ptrdiff_t first = static_cast<std::ptrdiff_t>(output * axis.stride) - axis.padding;
  const auto step = static_cast<std::ptrdiff_t>(axis.spacing);
  const auto before = [&](std::ptrdiff_t place) {  // taps that lie before it
    return place <= first ? std::size_t(0)
                          : std::min(axis.taps, static_cast<std::size_t>((place - first - 1) / step + 1));
  };
  return {before(0), std::max(before(0), before(static_cast<std::ptrdiff_t>(axis.input)))};
}
}  // namespace detail

/// A convolution of each channel with its own filter. It reads the inputs in place and leaves out taps
/// outside the picture. Arguments as convolve().
template <std::floating_point T>
void convolve_depthwise(const PackedConvolution<T>& packed, std::size_t images, const T* in,
                        const Epilogue<T>& end, T* out, std::size_t out_image_size) {
  const ConvolutionShape& shape = packed.shape;
  DepthwiseArguments<T> line{};
  line.in_row_step = shape.rows.spacing * shape.columns.input * shape.in_channels;
  line.column_taps = shape.columns.taps;
  line.column_stride = shape.columns.stride;
  line.column_spacing = shape.columns.spacing;
  line.column_padding = shape.columns.padding;
  line.in_columns = shape.columns.input;
  line.weight_step = round_up(shape.in_channels, kernels<T>().lanes);
  line.channel_count = shape.in_channels;
  line.out_columns = shape.columns.output;
  line.out_pixel_step = packed.column_step * shape.out_channels;
  line.end = end;
  line.end.origin = out;
  const double work = 2.0 * static_cast<double>(shape.taps() * shape.out_size());
  const std::size_t rows_at_once = block_count(shape.rows.output, detail::useful_tasks(work));
  const std::size_t tasks = block_count(shape.rows.output, rows_at_once);
  parallel_for(images * tasks, [&](std::size_t task) {
    const BlockRange rows = block_range(task % tasks, shape.rows.output, rows_at_once);
    const T* const picture = in + task / tasks * shape.in_size();
    T* const out_picture = out + task / tasks * out_image_size;
    DepthwiseArguments<T> own = line;
    for (std::size_t row = rows.begin; row < rows.end; ++row) {
      const BlockRange taps = detail::inner_taps(shape.rows, row);
      const std::ptrdiff_t first_row = static_cast<std::ptrdiff_t>(row * shape.rows.stride) -
                                       shape.rows.padding +
                                       static_cast<std::ptrdiff_t>(taps.begin * shape.rows.spacing);
      own.in = taps.begin == taps.end
                   ? picture
                   : picture + static_cast<std::size_t>(first_row) * shape.columns.input * shape.in_channels;
      own.row_taps = taps.end - taps.begin;
      own.weights = packed.weights->data() + taps.begin * shape.columns.taps * line.weight_step;
      own.out = out_picture +
                ((packed.first_row + row * packed.row_step) * packed.out_columns + packed.first_column) *
                    shape.out_channels;
      kernels<T>().depthwise_row(own);
    }
  });
}
}  // namespace tapestry::nn

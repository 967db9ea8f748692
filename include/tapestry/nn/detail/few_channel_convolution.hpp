#pragma once
#include <tapestry/nn/detail/packed_convolution.hpp>

namespace tapestry::nn {
/// True if convolve_few_channels() computes this convolution: at most four channels out, more in, stride 1.
template <std::floating_point T>
[[nodiscard]] bool has_few_channels(const PackedConvolution<T>& packed) {
  const ConvolutionShape& s = packed.shape;
  const auto fits = [](const AxisWindow& axis) { return axis.stride == 1 && axis.spacing == 1; };
  return s.out_channels <= 4 && s.in_channels >= 8 && s.groups == 1 && fits(s.rows) && fits(s.columns);
}

namespace detail {
template <std::floating_point T>
class FewChannelConvolution {
 public:
  FewChannelConvolution(const PackedConvolution<T>& packed, const T* in, const Epilogue<T>& end, T* out,
                        std::size_t out_image_size)
      : packed_(packed),
        shape_(packed.shape),
        in_(in),
        end_(end),
        out_(out),
        out_image_size_(out_image_size),
        product_count_(shape_.taps() * shape_.out_channels),
        product_step_(round_up(product_count_, kernels<T>().lanes)),
        row_size_(shape_.columns.reach(shape_.columns.output) * product_step_) {
    arrange_weights();
  }

  void run(std::size_t images) const {
    constexpr std::size_t rows_at_once = 16;
    const std::size_t tasks = block_count(shape_.rows.output, rows_at_once);
    parallel_for(images * tasks, [&](std::size_t task) {
      run_rows(task / tasks, block_range(task % tasks, shape_.rows.output, rows_at_once));
    });
  }

 private:
  /// [panel of products, input channel, lane], a product being (row tap, column tap, output channel).
  void arrange_weights() {
    const std::size_t lanes = kernels<T>().lanes;
    const std::size_t channels = shape_.in_channels;
    const std::size_t packed_width =  // width of the only panel, see panel_lanes()
        panel_lanes(0, round_up(shape_.out_channels, lanes), lanes);
    weights_.resize(product_step_ * channels);
    weights_.fill_zero();
    for (std::size_t p = 0; p < product_count_; ++p) {
      const std::size_t tap = p / shape_.out_channels;
      const std::size_t panel = p / (2 * lanes) * (2 * lanes);
      const std::size_t width = panel_lanes(panel, product_step_, lanes);
      const T* from = packed_.weights->data() + tap * channels * packed_width + p % shape_.out_channels;
      for (std::size_t i = 0; i < channels; ++i)
        weights_.data()[panel * channels + i * width + (p - panel)] = from[i * packed_width];
    }
  }

  void run_rows(std::size_t image, BlockRange rows) const {
    static thread_local Buffer<T> ring;  // products of the last input rows, as many as there are row taps
    const std::size_t taps = shape_.rows.taps;
    ring.resize(taps * row_size_);
    std::vector<const T*> tap_rows(taps);
    GatherArguments<T> gather{};
    gather.tap_rows = tap_rows.data();
    gather.row_taps = taps;
    gather.column_taps = shape_.columns.taps;
    gather.products_step = product_step_;
    gather.pixel_count = shape_.columns.output;
    gather.channel_count = shape_.out_channels;
    gather.out_pixel_step = packed_.column_step * shape_.out_channels;
    gather.end = end_;
    for (std::size_t made = rows.begin; made < rows.end + taps - 1; ++made) {
      multiply_row(image, made, ring.data() + made % taps * row_size_);
      if (made + 1 < rows.begin + taps) continue;
      const std::size_t row = made + 1 - taps;
      for (std::size_t t = 0; t < taps; ++t) tap_rows[t] = ring.data() + (row + t) % taps * row_size_;
      const std::size_t y = packed_.first_row + row * packed_.row_step;
      gather.out = out_ + image * out_image_size_ +
                   (y * packed_.out_columns + packed_.first_column) * shape_.out_channels;
      kernels<T>().gather_row(gather);
    }
  }

  /// Products of input row `made − padding`, with zeros where the row or a column lies outside.
  void multiply_row(std::size_t image, std::size_t made, T* products) const {
    const Kernels<T>& simd = kernels<T>();
    const auto padding = static_cast<std::ptrdiff_t>(shape_.columns.padding);
    const auto columns = static_cast<std::ptrdiff_t>(shape_.columns.input);
    const std::ptrdiff_t y = static_cast<std::ptrdiff_t>(made) - shape_.rows.padding;
    const auto extent = static_cast<std::ptrdiff_t>(shape_.columns.reach(shape_.columns.output));
    const bool is_outside = y < 0 || y >= static_cast<std::ptrdiff_t>(shape_.rows.input);
    const std::ptrdiff_t begin = is_outside ? extent : std::clamp(padding, std::ptrdiff_t(0), extent);
    const std::ptrdiff_t end = is_outside ? extent : std::clamp(columns + padding, begin, extent);
    const auto at = [&](std::ptrdiff_t x) { return products + static_cast<std::size_t>(x) * product_step_; };
    std::fill(products, at(begin), T(0));
    std::fill(at(end), products + row_size_, T(0));
    if (begin == end) return;
    ReduceArguments<T> a{};
    a.in_row_step = static_cast<std::ptrdiff_t>(shape_.in_channels);
    a.in_inner_step = 1;
    a.outer_count = 1;
    a.inner_count = shape_.in_channels;
    a.out_row_step = static_cast<std::ptrdiff_t>(product_step_);
    const T* picture = in_ + image * shape_.in_size();
    const T* first = picture + (static_cast<std::size_t>(y * columns + begin - padding)) * shape_.in_channels;
    const auto count = static_cast<std::size_t>(end - begin);
    const std::size_t tiles = block_count(count, simd.tile_rows);
    for (std::size_t t = 0; t < tiles; ++t) {
      const std::size_t from = count * t / tiles;
      const std::size_t height = count * (t + 1) / tiles - from;
      for (std::size_t panel = 0; panel < product_step_; panel += 2 * simd.lanes) {
        a.lane_count = panel_lanes(panel, product_step_, simd.lanes);
        a.in = first + from * shape_.in_channels;
        a.weights = weights_.data() + panel * shape_.in_channels;
        a.out = at(begin) + from * product_step_ + panel;
        simd.reduce[a.lane_count / simd.lanes - 1][height - 1](a);
      }
    }
  }

  const PackedConvolution<T>& packed_;
  const ConvolutionShape& shape_;
  const T* in_;
  Epilogue<T> end_;
  T* out_;
  std::size_t out_image_size_;
  std::size_t product_count_;
  std::size_t product_step_;
  std::size_t row_size_;
  Buffer<T> weights_;
};
}  // namespace detail

/// A convolution with at most four channels out, such as the adjoint of a network's first layer. A vector of
/// output channels would be nearly empty. So each input pixel is first multiplied with the filters of all
/// taps side by side,
///
///   P[q, (t, o)] = Σ_i in[q, i] · w[t, i, o],   out[p, o] = Σ_t P[p + t, (t, o)],
///
/// a few rows at a time. Arguments as convolve().
template <std::floating_point T>
void convolve_few_channels(const PackedConvolution<T>& packed, std::size_t images, const T* in,
                           const Epilogue<T>& end, T* out, std::size_t out_image_size) {
  detail::FewChannelConvolution<T>(packed, in, end, out, out_image_size).run(images);
}
}  // namespace tapestry::nn

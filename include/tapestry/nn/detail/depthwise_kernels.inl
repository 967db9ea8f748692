// Kernels of convolutions with a filter for each channel, for one instruction set.
#include <tapestry/nn/detail/reduce_kernels.inl>

/// P neighbouring outputs from x on, for taps that touch and lie in the row. An input is read once for all.
template <std::floating_point T, int Taps, int Stride, int P>
inline void depthwise_tile(const DepthwiseArguments<T>& a, const T* in, std::size_t x) {
  for (std::size_t channel = 0; channel < a.channel_count; channel += Vector<T>::lanes) {
    Register<T> sum[P][1];
#pragma GCC unroll 8
    for (int p = 0; p < P; ++p) sum[p][0] = Register<T>{};
    const T* row = in + channel;
    const T* weights = a.weights + channel;
    for (std::size_t y = 0; y < a.row_taps; ++y) {
      Register<T> weight[Taps];
#pragma GCC unroll 8
      for (int t = 0; t < Taps; ++t) weight[t] = load(weights + static_cast<std::size_t>(t) * a.weight_step);
#pragma GCC unroll 16
      for (int k = 0; k < (P - 1) * Stride + Taps; ++k) {
        const Register<T> value = load(row + static_cast<std::size_t>(k) * a.channel_count);
#pragma GCC unroll 8
        for (int p = 0; p < P; ++p)
          if (k >= p * Stride && k < p * Stride + Taps) sum[p][0] += weight[k - p * Stride] * value;
      }
      row += a.in_row_step;
      weights += Taps * a.weight_step;
    }
    store_tile<T, P, 1>(a.end, sum, channel, a.out + x * a.out_pixel_step + channel,
                        static_cast<std::ptrdiff_t>(a.out_pixel_step), a.channel_count - channel);
  }
}

/// One output, for any number of taps, stride and spacing, at the edges, too.
template <std::floating_point T>
inline void depthwise_pixel(const DepthwiseArguments<T>& a, std::size_t x) {
  const std::ptrdiff_t left = static_cast<std::ptrdiff_t>(x * a.column_stride) - a.column_padding;
  const auto spacing = static_cast<std::ptrdiff_t>(a.column_spacing);
  std::ptrdiff_t begin = 0, end = static_cast<std::ptrdiff_t>(a.column_taps);  // taps in the row
  while (begin < end && left + begin * spacing < 0) ++begin;
  while (begin < end && left + (end - 1) * spacing >= static_cast<std::ptrdiff_t>(a.in_columns)) --end;
  const std::ptrdiff_t first = (left + begin * spacing) * static_cast<std::ptrdiff_t>(a.channel_count);
  const std::ptrdiff_t step = spacing * static_cast<std::ptrdiff_t>(a.channel_count);
  for (std::size_t channel = 0; channel < a.channel_count; channel += Vector<T>::lanes) {
    Register<T> sum[1][1] = {};
    for (std::size_t y = 0; y < a.row_taps; ++y) {
      const T* in = a.in + y * a.in_row_step + channel;
      const T* weights = a.weights + y * a.column_taps * a.weight_step + channel;
      for (std::ptrdiff_t t = begin; t < end; ++t)
        sum[0][0] += load(weights + static_cast<std::size_t>(t) * a.weight_step) *
                     load(in + (first + (t - begin) * step));
    }
    store_tile<T, 1, 1>(a.end, sum, channel, a.out + x * a.out_pixel_step + channel, 0,
                        a.channel_count - channel);
  }
}

template <std::floating_point T, int Taps, int Stride>
void depthwise_outputs(const DepthwiseArguments<T>& a) {
  for (std::size_t x = 0; x < a.out_columns;) {
    const std::ptrdiff_t left = static_cast<std::ptrdiff_t>(x * Stride) - a.column_padding;
    const std::size_t in = static_cast<std::size_t>(left) * a.channel_count;  // used if it lies in the row
    const std::size_t end = static_cast<std::size_t>(left) + Taps;  // end of the first output's taps
    if (left >= 0 && x + 6 <= a.out_columns && end + 5 * Stride <= a.in_columns) {
      depthwise_tile<T, Taps, Stride, 6>(a, a.in + in, x);
      x += 6;
    } else if (left >= 0 && x + 3 <= a.out_columns && end + 2 * Stride <= a.in_columns) {
      depthwise_tile<T, Taps, Stride, 3>(a, a.in + in, x);
      x += 3;
    } else {
      depthwise_pixel(a, x++);
    }
  }
}

/// out[x, c] = Σ_{y, t} in[y, x·stride − padding + t·spacing, c] · weights[y, t, c]
template <std::floating_point T>
void depthwise_row(const DepthwiseArguments<T>& a) {
  if (a.column_spacing == 1 && a.column_stride == 1) {
    if (a.column_taps == 1) return depthwise_outputs<T, 1, 1>(a);
    if (a.column_taps == 2) return depthwise_outputs<T, 2, 1>(a);
    if (a.column_taps == 3) return depthwise_outputs<T, 3, 1>(a);
    if (a.column_taps == 5) return depthwise_outputs<T, 5, 1>(a);
  }
  if (a.column_spacing == 1 && a.column_stride == 2) {
    if (a.column_taps == 3) return depthwise_outputs<T, 3, 2>(a);
    if (a.column_taps == 5) return depthwise_outputs<T, 5, 2>(a);
  }
  for (std::size_t x = 0; x < a.out_columns; ++x) depthwise_pixel(a, x);
}

/// weights_adjoint[t, c] += Σ_x in[x, tap t, c] · out_adjoint[x, c]
template <std::floating_point T>
void depthwise_weight_adjoint_row(const DepthwiseWeightArguments<T>& a) {
  const std::size_t in_step = a.in_pixel_step, out_step = a.channel_count;
  for (std::size_t channel = 0; channel < a.channel_count; channel += Vector<T>::lanes) {
    for (std::size_t t = 0; t < a.tap_count; ++t) {
      Register<T> sum{};
      Register<T> sum_odd{};
      const T* in = a.in + a.tap_offsets[t] + channel;
      const T* adjoint = a.out_adjoint + channel;
      std::size_t x = 0;
      for (; x + 2 <= a.pixel_count; x += 2, in += 2 * in_step, adjoint += 2 * out_step) {
        sum += load(in) * load(adjoint);
        sum_odd += load(in + in_step) * load(adjoint + out_step);
      }
      if (x < a.pixel_count) sum += load(in) * load(adjoint);
      T* const weights_adjoint = a.weights_adjoint + t * a.weight_step + channel;
      store(weights_adjoint, load(weights_adjoint) + (sum + sum_odd));
    }
  }
}

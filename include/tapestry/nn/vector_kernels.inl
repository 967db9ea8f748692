// Kernels for one instruction set; vector_kernels.hpp includes this file once for each of them, inside a
// namespace of its own and with TAPESTRY_VECTOR_BYTES and TAPESTRY_TILE_ROWS set. Generic vectors must be
// parsed under the target they are meant for, so nothing here may be a lambda or come from outside.

template <class T>
struct Vector {
  static constexpr std::size_t lanes = TAPESTRY_VECTOR_BYTES / sizeof(T);
  typedef T Register __attribute__((vector_size(TAPESTRY_VECTOR_BYTES)));
  typedef T Memory __attribute__((vector_size(TAPESTRY_VECTOR_BYTES), aligned(sizeof(T)), may_alias));
};

template <class T>
using Register = typename Vector<T>::Register;

template <class T>
inline const typename Vector<T>::Memory& at(const T* values) {
  return *reinterpret_cast<const typename Vector<T>::Memory*>(values);
}
template <class T>
inline typename Vector<T>::Memory& at(T* values) {
  return *reinterpret_cast<typename Vector<T>::Memory*>(values);
}

/// Writes `count` ≤ lanes leading values of a sum: out = leaky(sum + bias + (out if it adds)).
template <class T>
inline void store(const Epilogue<T>& end, const Register<T>& sum, std::size_t first, T* out,
                  std::size_t count) {
  constexpr std::size_t lanes = Vector<T>::lanes;
  Register<T> value = sum;
  if (end.bias != nullptr) value += at(end.bias + first);
  if (count >= lanes) {
    if (end.adds) value += at(out);
    if (end.slope != T(1)) value = value > T(0) ? value : value * end.slope;
    at(out) = value;
    return;
  }
  T partial[lanes];
  at(&partial[0]) = value;
  for (std::size_t i = 0; i < count; ++i) {
    const T x = end.adds ? partial[i] + out[i] : partial[i];
    out[i] = x > 0 ? x : x * end.slope;
  }
}

/// out[p, lane] = Σ_r in[p, r] · weights[r, lane] for P rows and V registers of lanes; the reduction runs
/// over outer_count runs of inner_count values.
template <class T, int V, int P>
void reduce_tile(const ReduceArguments<T>& a) {
  constexpr std::size_t lanes = Vector<T>::lanes;
  Register<T> sum[P][V];
#pragma GCC unroll 16
  for (int p = 0; p < P; ++p)
#pragma GCC unroll 2
    for (int v = 0; v < V; ++v) sum[p][v] = Register<T>{};
  const T* weights = a.weights;
  const std::ptrdiff_t row = a.in_row_step;
  for (std::size_t outer = 0; outer < a.outer_count; ++outer) {
    // One pointer for three rows, so that all addresses are a register, or one plus one or two steps.
    const T* in[(P + 2) / 3];
#pragma GCC unroll 4
    for (int p = 0; p < P; p += 3)
      in[p / 3] = a.in + static_cast<std::ptrdiff_t>(outer) * a.in_outer_step + p * row;
    for (std::size_t inner = 0; inner < a.inner_count; ++inner) {
      Register<T> weight[V];
#pragma GCC unroll 2
      for (int v = 0; v < V; ++v) weight[v] = at(weights + static_cast<std::size_t>(v) * lanes);
#pragma GCC unroll 16
      for (int p = 0; p < P; ++p)
#pragma GCC unroll 2
        for (int v = 0; v < V; ++v) sum[p][v] += weight[v] * in[p / 3][p % 3 * row];
#pragma GCC unroll 4
      for (int p = 0; p < P; p += 3) in[p / 3] += a.in_inner_step;
      weights += static_cast<std::size_t>(V) * lanes;
    }
  }
#pragma GCC unroll 16
  for (int p = 0; p < P; ++p)
#pragma GCC unroll 2
    for (int v = 0; v < V; ++v) {
      const std::size_t first = static_cast<std::size_t>(v) * lanes;
      if (first < a.lane_count)
        store<T>(a.end, sum[p][v], first, a.out + p * a.out_row_step + first, a.lane_count - first);
    }
}

/// out[x, c] = Σ_t in[x, tap t, c] · weights[t, c] for P pixels and one register of channels.
template <class T, int P>
inline void depthwise_tile(const DepthwiseArguments<T>& a, const T* in, T* out, std::size_t channel) {
  Register<T> sum[P];
#pragma GCC unroll 8
  for (int p = 0; p < P; ++p) sum[p] = Register<T>{};
  for (std::size_t t = 0; t < a.tap_count; ++t) {
    const Register<T> weight = at(a.weights + t * a.weight_step + channel);
    const T* tap = in + a.tap_offsets[t] + channel;
#pragma GCC unroll 8
    for (int p = 0; p < P; ++p) sum[p] += weight * at(tap + p * a.in_pixel_step);
  }
#pragma GCC unroll 8
  for (int p = 0; p < P; ++p)
    store<T>(a.end, sum[p], channel, out + p * a.out_pixel_step + channel, a.channel_count - channel);
}

template <class T>
void depthwise_row(const DepthwiseArguments<T>& a) {
  for (std::size_t channel = 0; channel < a.channel_count; channel += Vector<T>::lanes) {
    std::size_t x = 0;
    const T* in = a.in;
    T* out = a.out;
    for (; x + 6 <= a.pixel_count; x += 6, in += 6 * a.in_pixel_step, out += 6 * a.out_pixel_step)
      depthwise_tile<T, 6>(a, in, out, channel);
    for (; x < a.pixel_count; ++x, in += a.in_pixel_step, out += a.out_pixel_step)
      depthwise_tile<T, 1>(a, in, out, channel);
  }
}

/// weights_adjoint[t, c] += Σ_x in[x, tap t, c] · out_adjoint[x, c]; here `weights` is the adjoint's base
/// and `out` the adjoint of the output, which is only read.
template <class T>
void depthwise_weight_adjoint_row(const DepthwiseArguments<T>& a, T* weights_adjoint) {
  for (std::size_t channel = 0; channel < a.channel_count; channel += Vector<T>::lanes) {
    for (std::size_t t = 0; t < a.tap_count; ++t) {
      Register<T> sum{};
      Register<T> sum_odd{};
      const T* in = a.in + a.tap_offsets[t] + channel;
      const T* adjoint = a.out + channel;
      std::size_t x = 0;
      for (; x + 2 <= a.pixel_count; x += 2, in += 2 * a.in_pixel_step, adjoint += 2 * a.out_pixel_step) {
        sum += at(in) * at(adjoint);
        sum_odd += at(in + a.in_pixel_step) * at(adjoint + a.out_pixel_step);
      }
      if (x < a.pixel_count) sum += at(in) * at(adjoint);
      at(weights_adjoint + t * a.weight_step + channel) += sum + sum_odd;
    }
  }
}

/// out[x, c] = Σ_{y, t} products[row y, x + t, (y, t, c)] for P pixels and up to four channels c.
template <class T, int P>
inline void gather_pixels(const GatherArguments<T>& a, std::size_t x, T* out, bool is_last) {
  typedef T Quad __attribute__((vector_size(4 * sizeof(T))));
  typedef T QuadMemory __attribute__((vector_size(4 * sizeof(T)), aligned(sizeof(T)), may_alias));
  Quad sum[P];
#pragma GCC unroll 4
  for (int p = 0; p < P; ++p) sum[p] = Quad{};
  for (std::size_t y = 0; y < a.row_taps; ++y) {
    const T* product = a.tap_rows[y] + x * a.products_step + y * a.column_taps * a.channel_count;
    for (std::size_t t = 0; t < a.column_taps; ++t, product += a.products_step + a.channel_count)
#pragma GCC unroll 4
      for (int p = 0; p < P; ++p)
        sum[p] +=
            *reinterpret_cast<const QuadMemory*>(product + static_cast<std::size_t>(p) * a.products_step);
  }
  const T count = static_cast<T>(a.channel_count);
  const auto is_channel = Quad{0, 1, 2, 3} < count;
  Quad bias{};
  for (std::size_t c = 0; c < a.channel_count && a.end.bias != nullptr; ++c) bias[c] = a.end.bias[c];
#pragma GCC unroll 4
  for (int p = 0; p < P; ++p, out += a.out_pixel_step) {
    if (is_last && p + 1 == P) {  // what follows its channels may belong to another thread
      for (std::size_t c = 0; c < a.channel_count; ++c) {
        const T value = sum[p][c] + bias[c] + (a.end.adds ? out[c] : T(0));
        out[c] = value > 0 ? value : value * a.end.slope;
      }
      return;
    }
    QuadMemory& to = *reinterpret_cast<QuadMemory*>(out);
    Quad value = sum[p] + bias;
    if (a.end.adds) value += to;
    if (a.end.slope != T(1)) value = value > T(0) ? value : value * a.end.slope;
    to = is_channel ? value : to;
  }
}

template <class T>
void gather_row(const GatherArguments<T>& a) {
  std::size_t x = 0;
  T* out = a.out;
  for (; x + 4 <= a.pixel_count; x += 4, out += 4 * a.out_pixel_step)
    gather_pixels<T, 4>(a, x, out, x + 4 == a.pixel_count);
  for (; x < a.pixel_count; ++x, out += a.out_pixel_step)
    gather_pixels<T, 1>(a, x, out, x + 1 == a.pixel_count);
}

#include <tapestry/nn/pointwise_kernels.inl>
#include <tapestry/nn/winograd_kernels.inl>

template <class T, int V, int P>
void fill_rows(Kernels<T>& kernels) {
  kernels.reduce[V - 1][P - 1] = &reduce_tile<T, V, P>;
  if constexpr (P > 1) fill_rows<T, V, P - 1>(kernels);
}

template <class T>
Kernels<T> make_kernels() {
  Kernels<T> kernels;
  kernels.lanes = Vector<T>::lanes;
  kernels.tile_rows = TAPESTRY_TILE_ROWS;
  fill_rows<T, 1, TAPESTRY_TILE_ROWS>(kernels);
  fill_rows<T, 2, TAPESTRY_TILE_ROWS>(kernels);
  fill_winograd<T, WinogradForm::f2_taps3>(kernels);
  fill_winograd<T, WinogradForm::f4_taps3>(kernels);
  fill_winograd<T, WinogradForm::f4_taps2>(kernels);
  kernels.gather_row = &gather_row<T>;
  kernels.depthwise_row = &depthwise_row<T>;
  kernels.depthwise_weight_adjoint_row = &depthwise_weight_adjoint_row<T>;
  kernels.add = &add<T>;
  kernels.positive_bits = &positive_bits<T>;
  kernels.leaky_adjoint = &leaky_adjoint<T>;
  kernels.affine = &affine<T>;
  kernels.combine = &combine<T>;
  kernels.periodic_sums = &periodic_sums<T>;
  kernels.max_pool_pixel = &max_pool_pixel<T>;
  return kernels;
}

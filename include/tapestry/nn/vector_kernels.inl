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

/// 2^i in lane i.
template <class T>
inline typename Vector<Position<T>>::Register lane_bits() {
  using Lanes = typename Vector<Position<T>>::Register;
  if constexpr (Vector<T>::lanes == 16) {
    return Lanes{1, 2, 4, 8, 16, 32, 64, 128, 256, 512, 1024, 2048, 4096, 8192, 16384, 32768};
  } else if constexpr (Vector<T>::lanes == 8) {
    return Lanes{1, 2, 4, 8, 16, 32, 64, 128};
  } else if constexpr (Vector<T>::lanes == 4) {
    return Lanes{1, 2, 4, 8};
  } else {
    return Lanes{1, 2};
  }
}

template <class T>
inline const typename Vector<T>::Memory& at(const T* values) {
  return *reinterpret_cast<const typename Vector<T>::Memory*>(values);
}
template <class T>
inline typename Vector<T>::Memory& at(T* values) {
  return *reinterpret_cast<typename Vector<T>::Memory*>(values);
}

/// Bit i: whether x[i] is above 0.
#if TAPESTRY_VECTOR_BYTES == 64
inline std::uint16_t positive_lanes(const Register<float>& x) {
  return static_cast<std::uint16_t>(__builtin_ia32_cmpps512_mask(x, Register<float>{}, 30, 0xffff, 4));
}
inline std::uint8_t positive_lanes(const Register<double>& x) {
  return static_cast<std::uint8_t>(__builtin_ia32_cmppd512_mask(x, Register<double>{}, 30, 0xff, 4));
}
#else
template <class R>
inline std::uint8_t positive_lanes(const R& x) {
  const R zero = {};
  const auto is_positive = x > zero;
#if TAPESTRY_VECTOR_BYTES == 32
  if constexpr (sizeof(x[0]) == 4)
    return static_cast<std::uint8_t>(__builtin_ia32_movmskps256((R)is_positive));
#endif
  unsigned bits = 0;
  for (std::size_t lane = 0; lane < sizeof(x) / sizeof(x[0]); ++lane)
    bits |= is_positive[lane] != 0 ? 1U << lane : 0U;
  return static_cast<std::uint8_t>(bits);
}
#endif

/// value · slope in the lanes whose bit is not set; `bits` are those of one vector, or of a byte.
template <class T>
inline Register<T> gated(const std::uint8_t* bits, const Register<T>& value, T slope) {
  using Lanes = typename Vector<Position<T>>::Register;
  using Word = std::conditional_t<Vector<T>::lanes == 16, std::uint16_t, std::uint8_t>;
  Word word;
  __builtin_memcpy(&word, bits, sizeof(word));
  return ((Lanes{} + static_cast<Position<T>>(word)) & lane_bits<T>()) != 0 ? value : value * slope;
}

/// Copies `count` < lanes values of a vector; most often half of them.
template <class T>
inline void copy_lanes(const T* from, T* to, std::size_t count) {
  if (count == Vector<T>::lanes / 2) {
    __builtin_memcpy(to, from, TAPESTRY_VECTOR_BYTES / 2);
  } else {
    __builtin_memcpy(to, from, count * sizeof(T));
  }
}

/// Writes `count` leading values, or all that there are.
template <class T>
inline void store_lanes(const Register<T>& value, T* out, std::size_t count) {
  if (count >= Vector<T>::lanes) {
    at(out) = value;
    return;
  }
  T partial[Vector<T>::lanes];
  at(&partial[0]) = value;
  copy_lanes(&partial[0], out, count);
}

/// Reads `count` leading values, or all that there are; the others are 0.
template <class T>
inline Register<T> load_lanes(const T* in, std::size_t count) {
  if (count >= Vector<T>::lanes) return at(in);
  T partial[Vector<T>::lanes] = {};
  copy_lanes(in, &partial[0], count);
  return at(&partial[0]);
}

/// What store_tile() does where its short way does not suffice: once for all tiles, to keep compilers quick.
template <class T>
__attribute__((noinline)) void store_sums(const Epilogue<T>& from, const Register<T>* sums, std::size_t rows,
                                          std::size_t registers, std::size_t first, T* out,
                                          std::ptrdiff_t step, std::size_t count) {
  constexpr std::size_t lanes = Vector<T>::lanes;
  const Epilogue<T> end = from;  // a copy, which stores cannot change
  for (std::size_t row = 0; row < rows; ++row, out += step, sums += registers) {
    const std::ptrdiff_t offset = end.origin == nullptr ? 0 : out - end.origin;
    for (std::size_t v = 0; v * lanes < count && v < registers; ++v) {
      const std::size_t left = count - v * lanes;
      const std::size_t place = static_cast<std::size_t>(offset) + v * lanes;
      Register<T> value = sums[v];
      if (end.bias != nullptr) value += at(end.bias + first + v * lanes);
      if (end.adds) value += load_lanes<T>(out + v * lanes, left);
      if (end.gate != nullptr) {
        value = gated<T>(end.gate + place / 8, value, end.slope);
      } else if (end.slope != T(1)) {
        value = value > T(0) ? value : value * end.slope;
      }
      if (end.positive != nullptr) {
        const auto bits = positive_lanes(value);
        __builtin_memcpy(end.positive + place / 8, &bits, sizeof(bits));
      }
      if (end.addend != nullptr) value += load_lanes<T>(end.addend + place, left);
      store_lanes<T>(value, out + v * lanes, left);
    }
  }
}

#define TAPESTRY_FOR_EACH_SUM \
  _Pragma("GCC unroll 16") for (int p = 0; p < P; ++p) _Pragma("GCC unroll 2") for (int v = 0; v < V; ++v)

/// Finishes sums of P outputs, `step` apart, and writes their `count` leading values, or all that there are,
/// as the epilogue says. In the short way the sums stay in registers.
template <class T, int P, int V>
inline void store_tile(const Epilogue<T>& end, Register<T> (&sum)[P][V], std::size_t first, T* out,
                       std::ptrdiff_t step, std::size_t count) {
  constexpr std::ptrdiff_t lanes = Vector<T>::lanes;
  const bool is_short =
      count >= V * lanes && end.gate == nullptr && end.positive == nullptr && end.addend == nullptr;
  if (!is_short) {
    Register<T> copy[P][V];
    TAPESTRY_FOR_EACH_SUM copy[p][v] = sum[p][v];
    return store_sums<T>(end, &copy[0][0], P, V, first, out, step, count);
  }
  if (end.bias != nullptr) TAPESTRY_FOR_EACH_SUM sum[p][v] += at(end.bias + first + v * lanes);
  if (end.adds) TAPESTRY_FOR_EACH_SUM sum[p][v] += at(out + p * step + v * lanes);
  if (end.slope != T(1))
    TAPESTRY_FOR_EACH_SUM sum[p][v] = sum[p][v] > T(0) ? sum[p][v] : sum[p][v] * end.slope;
  TAPESTRY_FOR_EACH_SUM at(out + p * step + v * lanes) = sum[p][v];
}

#undef TAPESTRY_FOR_EACH_SUM

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
  store_tile<T, P, V>(a.end, sum, 0, a.out, a.out_row_step, a.lane_count);
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

#include <tapestry/nn/depthwise_kernels.inl>
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

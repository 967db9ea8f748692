// Reductions to tiles and rows of outputs, for one instruction set.
#include <tapestry/nn/detail/epilogue_kernels.inl>

/// One step of a reduction: a product of values.
template <std::floating_point T>
struct ValueProduct {
  __attribute__((always_inline)) static inline Register<T> weight(const T* weights) { return load(weights); }
  __attribute__((always_inline)) static inline Register<T> added(Register<T> sum, Register<T> weight,
                                                                 const T* in) {
    return sum + weight * *in;
  }
};

/// out[p, lane] = Σ_r in[p, r] · weights[r, lane] for P rows and V registers of lanes. The reduction runs
/// over outer_count runs of inner_count values, or of the Product's own operands.
template <std::floating_point T, int V, int P, class Product = ValueProduct<T>>
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
    // One pointer for three rows: each address is then a register, or one plus one or two steps.
    const T* in[(P + 2) / 3];
#pragma GCC unroll 4
    for (int p = 0; p < P; p += 3)
      in[p / 3] = a.in + static_cast<std::ptrdiff_t>(outer) * a.in_outer_step + p * row;
    for (std::size_t inner = 0; inner < a.inner_count; ++inner) {
      decltype(Product::weight(weights)) weight[V];
#pragma GCC unroll 2
      for (int v = 0; v < V; ++v) weight[v] = Product::weight(weights + static_cast<std::size_t>(v) * lanes);
#pragma GCC unroll 16
      for (int p = 0; p < P; ++p)
#pragma GCC unroll 2
        for (int v = 0; v < V; ++v) sum[p][v] = Product::added(sum[p][v], weight[v], in[p / 3] + p % 3 * row);
#pragma GCC unroll 4
      for (int p = 0; p < P; p += 3) in[p / 3] += a.in_inner_step;
      weights += static_cast<std::size_t>(V) * lanes;
    }
  }
  store_tile<T, P, V>(a.end, sum, 0, a.out, a.out_row_step, a.lane_count);
}

/// out[x, c] = Σ_{y, t} products[row y, x + t, (y, t, c)] for P pixels and up to four channels c.
template <std::floating_point T, int P>
inline void gather_pixels(const GatherArguments<T>& a, std::size_t x, T* out) {
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
  const T* const row_end = a.out + (a.pixel_count - 1) * a.out_pixel_step + a.channel_count;
#pragma GCC unroll 4
  for (int p = 0; p < P; ++p, out += a.out_pixel_step) {
    if (row_end - out < 4) {  // memory behind the row may belong to another thread
      for (std::size_t c = 0; c < a.channel_count; ++c) {
        const T value = sum[p][c] + bias[c] + (a.end.adds ? out[c] : T(0));
        out[c] = value > 0 ? value : value * a.end.slope;
      }
      continue;
    }
    const Quad before = *reinterpret_cast<const QuadMemory*>(out);
    Quad value = sum[p] + bias;
    if (a.end.adds) value += before;
    if (a.end.slope != T(1)) value = value > T(0) ? value : value * a.end.slope;
    *reinterpret_cast<QuadMemory*>(out) = is_channel ? value : before;
  }
}

template <std::floating_point T>
void gather_row(const GatherArguments<T>& a) {
  std::size_t x = 0;
  T* out = a.out;
  for (; x + 4 <= a.pixel_count; x += 4, out += 4 * a.out_pixel_step) gather_pixels<T, 4>(a, x, out);
  for (; x < a.pixel_count; ++x, out += a.out_pixel_step) gather_pixels<T, 1>(a, x, out);
}

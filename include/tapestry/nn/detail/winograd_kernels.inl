// Winograd transforms for one instruction set. See winograd.hpp for the transforms' definition. All
// arithmetic is on registers of neighbouring channels.
#include <tapestry/nn/detail/bfloat16_words.inl>

#define TAPESTRY_INLINE inline __attribute__((always_inline))

/// One-dimensional transforms of each WinogradForm: `input` of `points` inputs, `filter` of `taps` taps and
/// `output` of `points` products, whose neighbours are `step` apart.
template <std::floating_point T, WinogradForm F>
struct Winograd;

/// Points {0, 1, −1, ∞}.
template <std::floating_point T>
struct Winograd<T, WinogradForm::f2_taps3> {
  static TAPESTRY_INLINE void input(const Register<T>* d, std::size_t step, Register<T>* v) {
    v[0] = d[0] - d[2 * step];
    v[1] = d[2 * step] + d[step];
    v[2] = d[2 * step] - d[step];
    v[3] = d[3 * step] - d[step];
  }
  static TAPESTRY_INLINE void filter(const Register<T>* g, std::size_t step, Register<T>* u) {
    const Register<T> even = (g[0] + g[2 * step]) * T(0.5);
    const Register<T> odd = g[step] * T(0.5);
    u[0] = g[0];
    u[1] = even + odd;
    u[2] = even - odd;
    u[3] = g[2 * step];
  }
  static TAPESTRY_INLINE void output(const Register<T>* m, std::size_t step, Register<T>* y) {
    y[0] = m[0] + (m[step] + m[2 * step]);
    y[1] = (m[step] - m[2 * step]) + m[3 * step];
  }
};

/// The points a, −a, b, −b with a = 2/3 and b = 3/2, so that a·b = 1.
template <std::floating_point T>
struct WinogradPoints {
  static constexpr T a = T(2.0 / 3), a2 = T(4.0 / 9), a3 = T(8.0 / 27);
  static constexpr T b = T(1.5), b2 = T(2.25), b3 = T(3.375);
  static constexpr T middle = T(97.0 / 36);  // a² + b²

  /// Four outputs from the products at a, −a, b, −b, without products of other points.
  static TAPESTRY_INLINE void output(const Register<T>* m, std::size_t step, Register<T>* y) {
    const Register<T> sum_a = m[0] + m[step], difference_a = m[0] - m[step];
    const Register<T> sum_b = m[2 * step] + m[3 * step], difference_b = m[2 * step] - m[3 * step];
    y[0] = sum_a + sum_b;
    y[1] = difference_a * a + difference_b * b;
    y[2] = sum_a * a2 + sum_b * b2;
    y[3] = difference_a * a3 + difference_b * b3;
  }
};

/// Points {0, a, −a, b, −b, ∞}.
template <std::floating_point T>
struct Winograd<T, WinogradForm::f4_taps3> {
  using P = WinogradPoints<T>;
  // 1/N(p), N(p) the product of p's distances from the other finite points
  static constexpr T from_a = T(-81.0 / 130), from_b = T(8.0 / 65);

  static TAPESTRY_INLINE void input(const Register<T>* d, std::size_t step, Register<T>* v) {
    const Register<T> d1 = d[step], d2 = d[2 * step], d3 = d[3 * step], d4 = d[4 * step];
    const Register<T> even_a = d4 - d2 * P::b2;
    const Register<T> odd_a = d3 * P::a - d1 * P::b;
    const Register<T> even_b = d4 - d2 * P::a2;
    const Register<T> odd_b = d3 * P::b - d1 * P::a;
    v[0] = (d[0] + d4) - d2 * P::middle;
    v[1] = even_a + odd_a;
    v[2] = even_a - odd_a;
    v[3] = even_b + odd_b;
    v[4] = even_b - odd_b;
    v[5] = (d[5 * step] + d1) - d3 * P::middle;
  }
  static TAPESTRY_INLINE void filter(const Register<T>* g, std::size_t step, Register<T>* u) {
    const Register<T> even_a = g[0] * from_a + g[2 * step] * (from_a * P::a2);
    const Register<T> odd_a = g[step] * (from_a * P::a);
    const Register<T> even_b = g[0] * from_b + g[2 * step] * (from_b * P::b2);
    const Register<T> odd_b = g[step] * (from_b * P::b);
    u[0] = g[0];
    u[1] = even_a + odd_a;
    u[2] = even_a - odd_a;
    u[3] = even_b + odd_b;
    u[4] = even_b - odd_b;
    u[5] = g[2 * step];
  }
  static TAPESTRY_INLINE void output(const Register<T>* m, std::size_t step, Register<T>* y) {
    P::output(m + step, step, y);
    y[0] += m[0];
    y[3] += m[5 * step];
  }
};

/// Points {a, −a, b, −b, ∞}.
template <std::floating_point T>
struct Winograd<T, WinogradForm::f4_taps2> {
  using P = WinogradPoints<T>;
  static constexpr T from_a = T(27.0 / 65), from_b = T(12.0 / 65);  // 1/N(−a), 1/N(b)

  static TAPESTRY_INLINE void input(const Register<T>* d, std::size_t step, Register<T>* v) {
    const Register<T> d0 = d[0], d1 = d[step], d2 = d[2 * step], d3 = d[3 * step];
    const Register<T> even_a = d3 - d1 * P::b2;
    const Register<T> odd_a = d2 * P::a - d0 * P::b;
    const Register<T> even_b = d3 - d1 * P::a2;
    const Register<T> odd_b = d2 * P::b - d0 * P::a;
    v[0] = even_a + odd_a;
    v[1] = even_a - odd_a;
    v[2] = even_b + odd_b;
    v[3] = even_b - odd_b;
    v[4] = (d0 + d[4 * step]) - d2 * P::middle;
  }
  static TAPESTRY_INLINE void filter(const Register<T>* g, std::size_t step, Register<T>* u) {
    const Register<T> first_a = g[0] * from_a, second_a = g[step] * (from_a * P::a);
    const Register<T> first_b = g[0] * from_b, second_b = g[step] * (from_b * P::b);
    u[0] = T(0) - first_a - second_a;
    u[1] = first_a - second_a;
    u[2] = first_b + second_b;
    u[3] = second_b - first_b;
    u[4] = g[step];
  }
  static TAPESTRY_INLINE void output(const Register<T>* m, std::size_t step, Register<T>* y) {
    P::output(m, step, y);
    y[3] += m[4 * step];
  }
};

/// U = G g Gᵀ for `channel_count` input channels and `width` filters.
template <std::floating_point T, WinogradForm F>
void winograd_filters(const WinogradFilterArguments<T>& a) {
  constexpr std::size_t count = extents_of(F).points;
  constexpr std::size_t tap_count = extents_of(F).taps;
  for (std::size_t i = 0; i < a.channel_count * a.width; i += Vector<T>::lanes) {
    Register<T> taps[tap_count * tap_count], half[count * tap_count], whole[count];
#pragma GCC unroll 9
    for (std::size_t t = 0; t < tap_count * tap_count; ++t) taps[t] = load(a.weights + t * a.tap_step + i);
#pragma GCC unroll 3
    for (std::size_t x = 0; x < tap_count; ++x) {
      Winograd<T, F>::filter(taps + x, tap_count, whole);
#pragma GCC unroll 6
      for (std::size_t y = 0; y < count; ++y) half[y * tap_count + x] = whole[y];
    }
#pragma GCC unroll 6
    for (std::size_t y = 0; y < count; ++y) {
      Winograd<T, F>::filter(half + y * tap_count, 1, whole);
#pragma GCC unroll 6
      for (std::size_t x = 0; x < count; ++x) store(a.out + (y * count + x) * a.point_step + i, whole[x]);
    }
  }
}

/// V = Bᵀ d B for one tile and `channel_count` channels, rounded up to whole registers; stored unchanged, or
/// as pairs of bfloat16 in half as many words.
template <std::floating_point T, WinogradForm F, bool Pairs = false>
void winograd_input(const WinogradInputArguments<T>& a) {
  constexpr std::size_t points = extents_of(F).points;
  for (std::size_t channel = 0; channel < a.channel_count; channel += Vector<T>::lanes) {
    const std::size_t first = a.first_channel + channel;
    Register<T> column[points], half[points * points], whole[points];
#pragma GCC unroll 6
    for (std::size_t x = 0; x < points; ++x) {
#pragma GCC unroll 6
      for (std::size_t y = 0; y < points; ++y) column[y] = load(a.pixels[y * points + x] + first);
      Winograd<T, F>::input(column, 1, whole);
#pragma GCC unroll 6
      for (std::size_t y = 0; y < points; ++y) half[y * points + x] = whole[y];
    }
    T* out = a.out + (Pairs ? channel / 2 : channel);
#pragma GCC unroll 6
    for (std::size_t y = 0; y < points; ++y) {
      Winograd<T, F>::input(half + y * points, 1, whole);
#pragma GCC unroll 6
      for (std::size_t x = 0; x < points; ++x) {
        T* const point = out + (y * points + x) * a.point_step;
        if constexpr (Pairs) {
          store_neighbours(point, whole[x]);
        } else {
          store(point, whole[x]);
        }
      }
    }
  }
}

/// y = Aᵀ m A for one tile; stores the first `rows` × `columns` of its pixels.
template <std::floating_point T, WinogradForm F>
void winograd_output(const WinogradOutputArguments<T>& a) {
  constexpr std::size_t points = extents_of(F).points;
  constexpr std::size_t outputs = extents_of(F).outputs;
  for (std::size_t first = 0; first < a.lane_count; first += Vector<T>::lanes) {
    Register<T> column[points], half[outputs * points], whole[outputs][1];
#pragma GCC unroll 6
    for (std::size_t x = 0; x < points; ++x) {
#pragma GCC unroll 6
      for (std::size_t y = 0; y < points; ++y)
        column[y] = load(a.sums + (y * points + x) * a.point_step + first);
      Winograd<T, F>::output(column, 1, whole[0]);
#pragma GCC unroll 4
      for (std::size_t y = 0; y < outputs; ++y) half[y * points + x] = whole[y][0];
    }
#pragma GCC unroll 4
    for (std::size_t y = 0; y < outputs; ++y) {
      if (y >= a.rows) break;
      Winograd<T, F>::output(half + y * points, 1, whole[0]);
      T* const out = a.out + y * a.row_step + first;
      const std::size_t count = a.lane_count - first;
      const auto step = static_cast<std::ptrdiff_t>(a.pixel_step);
      if (a.columns == outputs) {
        store_tile<T, outputs, 1>(a.end, whole, first, out, step, count);
        continue;
      }
      for (std::size_t x = 0; x < a.columns; ++x) {
        Register<T> one[1][1] = {{whole[x][0]}};
        store_tile<T, 1, 1>(a.end, one, first, out + x * a.pixel_step, 0, count);
      }
    }
  }
}

template <std::floating_point T, WinogradForm F>
void fill_winograd(Kernels<T>& kernels) {
  constexpr auto index = static_cast<std::size_t>(F);
  kernels.winograd_filters[index] = &winograd_filters<T, F>;
  kernels.winograd_input[index] = &winograd_input<T, F>;
  kernels.winograd_output[index] = &winograd_output<T, F>;
}

#undef TAPESTRY_INLINE

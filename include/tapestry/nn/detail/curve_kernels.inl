// Activations that are curves, for one instruction set. Curve defines them.
#include <tapestry/nn/detail/lane_kernels.inl>

/// The smaller and the larger of each lane and a number, in one instruction; NaN stays. GCC needs to be told.
template <std::floating_point T>
inline Register<T> at_most(T most, const Register<T>& x) {
  const Register<T> bound = most + Register<T>{};
#if TAPESTRY_VECTOR_BYTES == 64 && !defined(__clang__)
  if constexpr (sizeof(T) == 4) return __builtin_ia32_minps512_mask(bound, x, x, -1, 4);
#elif TAPESTRY_VECTOR_BYTES == 32 && !defined(__clang__)
  if constexpr (sizeof(T) == 4) return __builtin_ia32_minps256(bound, x);
#endif
  return bound < x ? bound : x;
}
template <std::floating_point T>
inline Register<T> at_least(T least, const Register<T>& x) {
  const Register<T> bound = least + Register<T>{};
#if TAPESTRY_VECTOR_BYTES == 64 && !defined(__clang__)
  if constexpr (sizeof(T) == 4) return __builtin_ia32_maxps512_mask(bound, x, x, -1, 4);
#elif TAPESTRY_VECTOR_BYTES == 32 && !defined(__clang__)
  if constexpr (sizeof(T) == 4) return __builtin_ia32_maxps256(bound, x);
#endif
  return bound > x ? bound : x;
}

/// x · 2^k, where k are integers and `shifted` is round_to_integer + k.
template <std::floating_point T>
inline Register<T> scaled_by_power(const Register<T>& x, [[maybe_unused]] const Register<T>& k,
                                   [[maybe_unused]] const Register<T>& shifted) {
#if TAPESTRY_VECTOR_BYTES == 64
#if defined(__clang__)
  constexpr unsigned short all_of_16 = 0xffff;
#else
  constexpr short all_of_16 = -1;  // as GCC declares the function
#endif
  if constexpr (sizeof(T) == 4) return __builtin_ia32_scalefps512_mask(x, k, x, all_of_16, 4);
  if constexpr (sizeof(T) == 8) return __builtin_ia32_scalefpd512_mask(x, k, x, 0xff, 4);
#endif
  using Format = tapestry::detail::ExponentialFormat<T>;
  using Bits = typename Vector<typename Format::Bits>::Register;
  return x * (Register<T>)(((Bits)shifted + Format::bias) << Format::mantissa_bits);
}

// Functions below work on N vectors side by side, an operation at a time, since operations on one
// vector wait for each other.
#define TAPESTRY_FOR_EACH _Pragma("GCC unroll 4") for (int i = 0; i < N; ++i)

/// x = exp x in each lane as tapestry::detail::vector_exp(), but cut at both ends, where it stays finite.
template <std::floating_point T, int N>
__attribute__((always_inline)) inline void cut_exp(Register<T> (&x)[N]) {
  using Format = tapestry::detail::ExponentialFormat<T>;
  constexpr auto& terms = tapestry::detail::ExponentialTerms<T>::terms;
  constexpr std::size_t count = sizeof(terms) / sizeof(terms[0]);
  Register<T> shifted[N], k[N], tail[N];
  TAPESTRY_FOR_EACH x[i] = at_most<T>(Format::largest_finite, x[i]);
  TAPESTRY_FOR_EACH x[i] = at_least<T>(Format::least, x[i]);
  TAPESTRY_FOR_EACH shifted[i] = x[i] * static_cast<T>(1.4426950408889634) + Format::round_to_integer;
  TAPESTRY_FOR_EACH k[i] = shifted[i] - Format::round_to_integer;
  TAPESTRY_FOR_EACH x[i] = x[i] - k[i] * Format::ln2_high;
  TAPESTRY_FOR_EACH x[i] = x[i] - k[i] * Format::ln2_low;
  TAPESTRY_FOR_EACH tail[i] = x[i] * terms[count - 1] + terms[count - 2];
  for (std::size_t t = count - 2; t-- > 0;) TAPESTRY_FOR_EACH tail[i] = tail[i] * x[i] + terms[t];
  TAPESTRY_FOR_EACH tail[i] = tail[i] * x[i] + T(1);
  TAPESTRY_FOR_EACH x[i] = tail[i] * x[i] + T(1);
  TAPESTRY_FOR_EACH x[i] = scaled_by_power<T>(x[i], k[i], shifted[i]);
}

/// x = 1 / x of x from 1 to the largest power of e.
template <std::floating_point T, int N>
__attribute__((always_inline)) inline void invert(Register<T> (&x)[N]) {
#if TAPESTRY_VECTOR_BYTES == 64
  if constexpr (sizeof(T) == 4) {  // 14 bits, and twice as many by a step of Newton's method
    Register<T> near[N];
    TAPESTRY_FOR_EACH near[i] = __builtin_ia32_rcp14ps512_mask(x[i], x[i], 0xffff);
    TAPESTRY_FOR_EACH x[i] = T(2) - x[i] * near[i];
    TAPESTRY_FOR_EACH x[i] = x[i] * near[i];
    return;
  }
#endif
  TAPESTRY_FOR_EACH x[i] = T(1) / x[i];
}

/// s = σ(x), and e = e^−x as cut: e · s is σ(−x) to the last digits at either end.
template <std::floating_point T, int N>
__attribute__((always_inline)) inline void logistic_lanes(const Register<T> (&x)[N], Register<T> (&s)[N],
                                                          Register<T> (&e)[N]) {
  TAPESTRY_FOR_EACH e[i] = -x[i];
  cut_exp<T>(e);
  TAPESTRY_FOR_EACH s[i] = e[i] + T(1);
  invert<T>(s);
}

/// e = e^x, and n with tanh(log(1 + e^x)) = n / (n + 2), for x up to 20, where the quotient is 1 to the last
/// digit of T.
template <std::floating_point T, int N>
__attribute__((always_inline)) inline void mish_terms(const Register<T> (&x)[N], Register<T> (&e)[N],
                                                      Register<T> (&n)[N]) {
  TAPESTRY_FOR_EACH e[i] = at_most<T>(T(20), x[i]);
  cut_exp<T>(e);
  TAPESTRY_FOR_EACH n[i] = e[i] * (e[i] + T(2));
}

/// x = curve(x) and, if wanted, slope = curve'(x).
template <std::floating_point T, CurveKind K, bool WantsSlope, int N>
__attribute__((always_inline)) inline void curve_lanes(const Curve<T>& curve, Register<T> (&x)[N],
                                                       Register<T> (&slope)[N]) {
  Register<T> s[N], e[N];
  if constexpr (K == CurveKind::logistic || K == CurveKind::swish) {
    constexpr bool is_swish = K == CurveKind::swish;
    logistic_lanes<T>(x, s, e);
    if constexpr (WantsSlope) {
      TAPESTRY_FOR_EACH slope[i] = e[i] * s[i];
      TAPESTRY_FOR_EACH slope[i] = is_swish ? s[i] * (x[i] * slope[i] + T(1)) : s[i] * slope[i];
    }
    TAPESTRY_FOR_EACH x[i] = is_swish ? x[i] * s[i] : s[i];
  } else if constexpr (K == CurveKind::mish) {
    Register<T> n[N];
    mish_terms<T>(x, e, n);
    TAPESTRY_FOR_EACH s[i] = n[i] / (n[i] + T(2));
    if constexpr (WantsSlope) TAPESTRY_FOR_EACH {
        // (1 − t²) · σ(x) with 1 − t² = (4n + 4)/(n + 2)² and σ(x) = e/(e + 1)
        const Register<T> one = T(1) + Register<T>{}, sum = n[i] + T(2);
        slope[i] = s[i] + x[i] * (e[i] / (e[i] + T(1))) * (n[i] * T(4) + T(4)) / (sum * sum);
        slope[i] = x[i] > T(20) ? one : slope[i];
      }
    TAPESTRY_FOR_EACH x[i] = x[i] * s[i];
  } else if constexpr (K == CurveKind::hard_logistic || K == CurveKind::hard_swish) {
    constexpr bool is_swish = K == CurveKind::hard_swish;
    TAPESTRY_FOR_EACH {
      const Register<T> zero = {}, y = x[i] * curve.a + curve.b;
      const Register<T> unit = at_most<T>(1, at_least<T>(0, y));
      const Register<T> inside = is_swish ? y + x[i] * curve.a : curve.a + zero;
      slope[i] = ((y > T(0)) & (y < T(1))) ? inside : (is_swish ? unit : zero);
      x[i] = is_swish ? x[i] * unit : unit;
    }
  } else {
    TAPESTRY_FOR_EACH {
      const Register<T> zero = {}, one = T(1) + zero;
      slope[i] = ((x[i] > curve.a) & (x[i] < curve.b)) ? one : zero;
      x[i] = at_most<T>(curve.b, at_least<T>(curve.a, x[i]));
    }
  }
}

/// Calls X<T, K, wants> with the curve's kind as K and whether slopes are wanted.
#define TAPESTRY_CURVE(K, WANTS, X, ...) \
  case CurveKind::K:                     \
    return (WANTS ? X<T, CurveKind::K, true> : X<T, CurveKind::K, false>)(__VA_ARGS__);
#define TAPESTRY_BY_CURVE(KIND, ...)           \
  switch (KIND) {                              \
    TAPESTRY_CURVE(logistic, __VA_ARGS__)      \
    TAPESTRY_CURVE(swish, __VA_ARGS__)         \
    TAPESTRY_CURVE(mish, __VA_ARGS__)          \
    TAPESTRY_CURVE(hard_logistic, __VA_ARGS__) \
    TAPESTRY_CURVE(hard_swish, __VA_ARGS__)    \
    case CurveKind::none:                      \
      TAPESTRY_CURVE(clip, __VA_ARGS__)        \
  }

/// N vectors from place `first` on; `count` of the last one, or all of each.
template <std::floating_point T, CurveKind K, bool WantsSlope, int N>
__attribute__((always_inline)) inline void curve_block(const Curve<T>& curve, const T* from, T* to, T* slopes,
                                                       std::size_t first, std::size_t count) {
  constexpr std::size_t lanes = Vector<T>::lanes;
  Register<T> x[N], slope[N];
  TAPESTRY_FOR_EACH x[i] = load_lanes<T>(from + first + static_cast<std::size_t>(i) * lanes, count);
  curve_lanes<T, K, WantsSlope>(curve, x, slope);
  TAPESTRY_FOR_EACH store_lanes<T>(x[i], to + first + static_cast<std::size_t>(i) * lanes, count);
  if constexpr (WantsSlope)
    TAPESTRY_FOR_EACH store_lanes<T>(slope[i], slopes + first + static_cast<std::size_t>(i) * lanes, count);
}

template <std::floating_point T, CurveKind K, bool WantsSlope>
void curve_all(const Curve<T>& curve, const T* from, T* to, T* slopes, std::size_t count) {
  constexpr std::size_t lanes = Vector<T>::lanes;
  const Curve<T> own = curve;
  std::size_t i = 0;
  for (; i + 4 * lanes <= count; i += 4 * lanes)
    curve_block<T, K, WantsSlope, 4>(own, from, to, slopes, i, lanes);
  for (; i < count; i += lanes) curve_block<T, K, WantsSlope, 1>(own, from, to, slopes, i, count - i);
}

/// to[i] = curve(from[i]), slopes[i] = curve'(from[i]) unless null; `from` and `to` may be the same
template <std::floating_point T>
void apply_curve(const Curve<T>& curve, const T* from, T* to, T* slopes, std::size_t count) {
  TAPESTRY_BY_CURVE(curve.kind, slopes != nullptr, curve_all, curve, from, to, slopes, count)
}

/// Sums `first_sum` to first_sum + N − 1 of store_one_curve().
template <std::floating_point T, CurveKind K, bool WantsSlope, int N>
__attribute__((always_inline)) inline void store_curve_block(const Epilogue<T>& end, const Register<T>* sums,
                                                             std::size_t first_sum, std::size_t registers,
                                                             std::size_t first, T* out, std::ptrdiff_t step,
                                                             std::size_t count) {
  constexpr std::size_t lanes = Vector<T>::lanes;
  Register<T> value[N], slope[N];
  T* place[N];
  std::size_t left[N];
  TAPESTRY_FOR_EACH {
    const std::size_t sum = first_sum + static_cast<std::size_t>(i);
    const std::size_t v = registers == 2 ? sum % 2 : 0, row = registers == 2 ? sum / 2 : sum;
    place[i] = out + static_cast<std::ptrdiff_t>(row) * step + v * lanes;
    left[i] = count > v * lanes ? count - v * lanes : 0;
    value[i] = sums[sum];
    if (end.bias != nullptr) value[i] += load(end.bias + first + v * lanes);
  }
  if (end.adds) TAPESTRY_FOR_EACH value[i] += load_lanes<T>(place[i], left[i]);
  curve_lanes<T, K, WantsSlope>(end.curve, value, slope);
  if constexpr (WantsSlope)
    TAPESTRY_FOR_EACH store_lanes<T>(slope[i], end.slopes + (place[i] - end.origin), left[i]);
  if (end.addend != nullptr)
    TAPESTRY_FOR_EACH value[i] += load_lanes<T>(end.addend + (place[i] - end.origin), left[i]);
  TAPESTRY_FOR_EACH store_lanes<T>(value[i], place[i], left[i]);
}

/// store_any() for an epilogue with a curve.
template <std::floating_point T, CurveKind K, bool WantsSlope>
__attribute__((noinline)) void store_one_curve(const Epilogue<T>& from, const Register<T>* sums,
                                               std::size_t rows, std::size_t registers, std::size_t first,
                                               T* out, std::ptrdiff_t step, std::size_t count) {
  const Epilogue<T> end = from;  // a copy, which stores cannot change
  const std::size_t sum_count = rows * registers;
  std::size_t sum = 0;
  for (; sum + 4 <= sum_count; sum += 4)
    store_curve_block<T, K, WantsSlope, 4>(end, sums, sum, registers, first, out, step, count);
  for (; sum < sum_count; ++sum)
    store_curve_block<T, K, WantsSlope, 1>(end, sums, sum, registers, first, out, step, count);
}

template <std::floating_point T>
__attribute__((noinline)) void store_curved(const Epilogue<T>& end, const Register<T>* sums, std::size_t rows,
                                            std::size_t registers, std::size_t first, T* out,
                                            std::ptrdiff_t step, std::size_t count) {
  TAPESTRY_BY_CURVE(end.curve.kind, end.slopes != nullptr, store_one_curve, end, sums, rows, registers, first,
                    out, step, count)
}

#undef TAPESTRY_BY_CURVE
#undef TAPESTRY_CURVE
#undef TAPESTRY_FOR_EACH

// Activations that are curves, for one instruction set. Curve defines them.
#include <tapestry/nn/detail/lane_kernels.inl>

/// The smaller and the larger of each lane and a number, in forms that become one instruction; NaN stays.
template <std::floating_point T>
inline Register<T> at_most(T most, const Register<T>& x) {
  const Register<T> bound = most + Register<T>{};
  return bound < x ? bound : x;
}
template <std::floating_point T>
inline Register<T> at_least(T least, const Register<T>& x) {
  const Register<T> bound = least + Register<T>{};
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
inline void cut_exp(Register<T> (&x)[N]) {
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
inline void invert(Register<T> (&x)[N]) {
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

/// s = σ(x)
template <std::floating_point T, int N>
inline void logistic_lanes(const Register<T> (&x)[N], Register<T> (&s)[N]) {
  TAPESTRY_FOR_EACH s[i] = -x[i];
  cut_exp<T>(s);
  TAPESTRY_FOR_EACH s[i] = s[i] + T(1);
  invert<T>(s);
}

/// x between 0 and 1; NaN stays.
template <std::floating_point T>
inline Register<T> unit_lanes(const Register<T>& x) {
  const Register<T> one = T(1) + Register<T>{};
  const Register<T> above = x < T(0) ? Register<T>{} : x;
  return above > T(1) ? one : above;
}

/// e = e^x, and n with tanh(log(1 + e^x)) = n / (n + 2), for x up to 20, where the quotient is 1 to the last
/// digit of T.
template <std::floating_point T, int N>
inline void mish_terms(const Register<T> (&x)[N], Register<T> (&e)[N], Register<T> (&n)[N]) {
  TAPESTRY_FOR_EACH e[i] = at_most<T>(T(20), x[i]);
  cut_exp<T>(e);
  TAPESTRY_FOR_EACH n[i] = e[i] * (e[i] + T(2));
}

/// x = curve(x)
template <std::floating_point T, CurveKind K, int N>
inline void curve_lanes(const Curve<T>& curve, Register<T> (&x)[N]) {
  Register<T> s[N], n[N];
  if constexpr (K == CurveKind::logistic) {
    logistic_lanes<T>(x, s);
    TAPESTRY_FOR_EACH x[i] = s[i];
  } else if constexpr (K == CurveKind::swish) {
    logistic_lanes<T>(x, s);
    TAPESTRY_FOR_EACH x[i] = x[i] * s[i];
  } else if constexpr (K == CurveKind::mish) {
    mish_terms<T>(x, s, n);
    TAPESTRY_FOR_EACH x[i] = x[i] * (n[i] / (n[i] + T(2)));
  } else if constexpr (K == CurveKind::hard_logistic) {
    TAPESTRY_FOR_EACH x[i] = unit_lanes<T>(x[i] * curve.a + curve.b);
  } else if constexpr (K == CurveKind::hard_swish) {
    TAPESTRY_FOR_EACH x[i] = x[i] * unit_lanes<T>(x[i] * curve.a + curve.b);
  } else {
    TAPESTRY_FOR_EACH x[i] = at_most<T>(curve.b, at_least<T>(curve.a, x[i]));
  }
}

/// x = curve'(x)
template <std::floating_point T, CurveKind K, int N>
inline void curve_slope_lanes(const Curve<T>& curve, Register<T> (&x)[N]) {
  const Register<T> zero = {}, one = T(1) + zero;
  Register<T> s[N], other[N];
  if constexpr (K == CurveKind::logistic || K == CurveKind::swish) {
    logistic_lanes<T>(x, s);
    TAPESTRY_FOR_EACH other[i] = -x[i];
    Register<T> falling[N];
    logistic_lanes<T>(other, falling);
    TAPESTRY_FOR_EACH x[i] = K == CurveKind::logistic ? s[i] * falling[i] : s[i] * (x[i] * falling[i] + T(1));
  } else if constexpr (K == CurveKind::mish) {
    mish_terms<T>(x, s, other);
    TAPESTRY_FOR_EACH {
      const Register<T> e = s[i], n = other[i], sum = n + T(2);
      // (1 − t²) · σ(x) with 1 − t² = (4n + 4)/(n + 2)² and σ(x) = e/(e + 1)
      const Register<T> slope = n / sum + x[i] * (e / (e + T(1))) * (n * T(4) + T(4)) / (sum * sum);
      x[i] = x[i] > T(20) ? one : slope;
    }
  } else if constexpr (K == CurveKind::hard_logistic || K == CurveKind::hard_swish) {
    TAPESTRY_FOR_EACH {
      const Register<T> y = x[i] * curve.a + curve.b;
      const Register<T> inside = K == CurveKind::hard_logistic ? curve.a + zero : y + x[i] * curve.a;
      const Register<T> outside = K == CurveKind::hard_logistic ? zero : unit_lanes<T>(y);
      x[i] = ((y > T(0)) & (y < T(1))) ? inside : outside;
    }
  } else {
    TAPESTRY_FOR_EACH x[i] = ((x[i] > curve.a) & (x[i] < curve.b)) ? one : zero;
  }
}

/// Calls X<T, K> with the curve's kind as K.
#define TAPESTRY_BY_CURVE(KIND, X, ...)                   \
  switch (KIND) {                                         \
    case CurveKind::logistic:                             \
      return X<T, CurveKind::logistic>(__VA_ARGS__);      \
    case CurveKind::swish:                                \
      return X<T, CurveKind::swish>(__VA_ARGS__);         \
    case CurveKind::mish:                                 \
      return X<T, CurveKind::mish>(__VA_ARGS__);          \
    case CurveKind::hard_logistic:                        \
      return X<T, CurveKind::hard_logistic>(__VA_ARGS__); \
    case CurveKind::hard_swish:                           \
      return X<T, CurveKind::hard_swish>(__VA_ARGS__);    \
    default:                                              \
      return X<T, CurveKind::clip>(__VA_ARGS__);          \
  }

template <std::floating_point T, CurveKind K, int N>
inline void curve_block(const Curve<T>& curve, const T* from, T* to, std::size_t count) {
  constexpr std::size_t lanes = Vector<T>::lanes;
  Register<T> x[N];
  TAPESTRY_FOR_EACH x[i] = load_lanes<T>(from + static_cast<std::size_t>(i) * lanes, count);
  curve_lanes<T, K>(curve, x);
  TAPESTRY_FOR_EACH store_lanes<T>(x[i], to + static_cast<std::size_t>(i) * lanes, count);
}

template <std::floating_point T, CurveKind K>
void apply_one_curve(const Curve<T>& curve, const T* from, T* to, std::size_t count) {
  constexpr std::size_t lanes = Vector<T>::lanes;
  const Curve<T> own = curve;
  std::size_t i = 0;
  for (; i + 4 * lanes <= count; i += 4 * lanes) curve_block<T, K, 4>(own, from + i, to + i, lanes);
  for (; i < count; i += lanes) curve_block<T, K, 1>(own, from + i, to + i, count - i);
}

/// to[i] = curve(from[i]); both may be the same
template <std::floating_point T>
void apply_curve(const Curve<T>& curve, const T* from, T* to, std::size_t count) {
  TAPESTRY_BY_CURVE(curve.kind, apply_one_curve, curve, from, to, count)
}

template <std::floating_point T, CurveKind K, int N>
inline void curve_adjoint_block(const Curve<T>& curve, const T* argument, const T* from, T* to,
                                std::size_t count) {
  constexpr std::size_t lanes = Vector<T>::lanes;
  Register<T> x[N];
  TAPESTRY_FOR_EACH x[i] = load_lanes<T>(argument + static_cast<std::size_t>(i) * lanes, count);
  curve_slope_lanes<T, K>(curve, x);
  TAPESTRY_FOR_EACH {
    const std::size_t place = static_cast<std::size_t>(i) * lanes;
    store_lanes<T>(x[i] * load_lanes<T>(from + place, count), to + place, count);
  }
}

template <std::floating_point T, CurveKind K>
void one_curve_adjoint(const Curve<T>& curve, const T* argument, const T* from, T* to, std::size_t count) {
  constexpr std::size_t lanes = Vector<T>::lanes;
  const Curve<T> own = curve;
  std::size_t i = 0;
  for (; i + 2 * lanes <= count; i += 2 * lanes)
    curve_adjoint_block<T, K, 2>(own, argument + i, from + i, to + i, lanes);
  for (; i < count; i += lanes) curve_adjoint_block<T, K, 1>(own, argument + i, from + i, to + i, count - i);
}

/// to[i] = curve'(argument[i]) · from[i]; `from` and `to` may be the same
template <std::floating_point T>
void curve_adjoint(const Curve<T>& curve, const T* argument, const T* from, T* to, std::size_t count) {
  TAPESTRY_BY_CURVE(curve.kind, one_curve_adjoint, curve, argument, from, to, count)
}

/// Sums `first_sum` to first_sum + N − 1 of store_one_curve().
template <std::floating_point T, CurveKind K, int N>
inline void store_curve_block(const Epilogue<T>& end, const Register<T>* sums, std::size_t first_sum,
                              std::size_t registers, std::size_t first, T* out, std::ptrdiff_t step,
                              std::size_t count) {
  constexpr std::size_t lanes = Vector<T>::lanes;
  Register<T> value[N];
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
  if (end.argument != nullptr)
    TAPESTRY_FOR_EACH store_lanes<T>(value[i], end.argument + (place[i] - end.origin), left[i]);
  curve_lanes<T, K>(end.curve, value);
  if (end.addend != nullptr)
    TAPESTRY_FOR_EACH value[i] += load_lanes<T>(end.addend + (place[i] - end.origin), left[i]);
  TAPESTRY_FOR_EACH store_lanes<T>(value[i], place[i], left[i]);
}

/// store_any() for an epilogue with a curve.
template <std::floating_point T, CurveKind K>
__attribute__((noinline)) void store_one_curve(const Epilogue<T>& from, const Register<T>* sums,
                                               std::size_t rows, std::size_t registers, std::size_t first,
                                               T* out, std::ptrdiff_t step, std::size_t count) {
  const Epilogue<T> end = from;  // a copy, which stores cannot change
  const std::size_t sum_count = rows * registers;
  std::size_t sum = 0;
  for (; sum + 4 <= sum_count; sum += 4)
    store_curve_block<T, K, 4>(end, sums, sum, registers, first, out, step, count);
  for (; sum < sum_count; ++sum)
    store_curve_block<T, K, 1>(end, sums, sum, registers, first, out, step, count);
}

template <std::floating_point T>
inline void store_curved(const Epilogue<T>& end, const Register<T>* sums, std::size_t rows,
                         std::size_t registers, std::size_t first, T* out, std::ptrdiff_t step,
                         std::size_t count) {
  TAPESTRY_BY_CURVE(end.curve.kind, store_one_curve, end, sums, rows, registers, first, out, step, count)
}

#undef TAPESTRY_BY_CURVE
#undef TAPESTRY_FOR_EACH

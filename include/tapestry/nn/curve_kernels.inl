// Activations that are curves, for one instruction set; vector_kernels.inl includes this file, under the same
// rules. See Curve for what they are.

/// The smaller and the larger of each lane and a number, in the form that is one instruction; NaN stays.
template <class T>
inline Register<T> at_most(T most, const Register<T>& x) {
  const Register<T> bound = most + Register<T>{};
  return bound < x ? bound : x;
}
template <class T>
inline Register<T> at_least(T least, const Register<T>& x) {
  const Register<T> bound = least + Register<T>{};
  return bound > x ? bound : x;
}

/// x · 2^k, where k are integers and `shifted` is round_to_integer + k.
template <class T>
inline Register<T> scaled_by_power(const Register<T>& x, [[maybe_unused]] const Register<T>& k,
                                   [[maybe_unused]] const Register<T>& shifted) {
#if TAPESTRY_VECTOR_BYTES == 64
#if defined(__clang__)
  constexpr unsigned short all_of_16 = 0xffff;
  constexpr unsigned char all_of_8 = 0xff;
#else
  constexpr short all_of_16 = -1;
  constexpr signed char all_of_8 = -1;
#endif
  if constexpr (sizeof(T) == 4) return __builtin_ia32_scalefps512_mask(x, k, x, all_of_16, 4);
  if constexpr (sizeof(T) == 8) return __builtin_ia32_scalefpd512_mask(x, k, x, all_of_8, 4);
#endif
  using Format = tapestry::detail::ExponentialFormat<T>;
  using Bits = typename Vector<typename Format::Bits>::Register;
  return x * (Register<T>)(((Bits)shifted + Format::bias) << Format::mantissa_bits);
}

/// exp x in each lane as tapestry::detail::vector_exp(), but cut at both ends, where it stays finite.
template <class T>
inline Register<T> cut_exp(const Register<T>& x) {
  using Format = tapestry::detail::ExponentialFormat<T>;
  constexpr auto& terms = tapestry::detail::ExponentialTerms<T>::terms;
  constexpr std::size_t count = sizeof(terms) / sizeof(terms[0]);
  const Register<T> within = at_least<T>(Format::least, at_most<T>(Format::largest_finite, x));
  const Register<T> shifted = within * static_cast<T>(1.4426950408889634) + Format::round_to_integer;
  const Register<T> k = shifted - Format::round_to_integer;
  const Register<T> r = (within - k * Format::ln2_high) - k * Format::ln2_low;
  Register<T> tail = terms[count - 1] + Register<T>{};
  for (std::size_t i = count - 1; i-- > 0;) tail = tail * r + terms[i];
  const Register<T> power = (tail * r + T(1)) * r + T(1);
  return scaled_by_power<T>(power, k, shifted);
}

/// 1 / x of x from 1 to the largest power of e.
template <class T>
inline Register<T> reciprocal_lanes(const Register<T>& x) {
#if TAPESTRY_VECTOR_BYTES == 64
  if constexpr (sizeof(T) == 4) {  // 14 bits, and twice as many by a step of Newton's method
    const Register<T> near = __builtin_ia32_rcp14ps512_mask(x, x, 0xffff);
    return near * (T(2) - x * near);
  }
#endif
  return T(1) / x;
}

template <class T>
inline Register<T> logistic_lanes(const Register<T>& x) {
  return reciprocal_lanes<T>(cut_exp<T>(-x) + T(1));
}

/// x between 0 and 1; NaN stays.
template <class T>
inline Register<T> unit_lanes(const Register<T>& x) {
  const Register<T> one = T(1) + Register<T>{};
  const Register<T> above = x < T(0) ? Register<T>{} : x;
  return above > T(1) ? one : above;
}

/// n with tanh(log(1 + e^x)) = n / (n + 2), for x up to 20, where the quotient is 1 to the last digit of T.
template <class T>
inline Register<T> mish_term(const Register<T>& x, Register<T>& e) {
  const Register<T> most = T(20) + Register<T>{};
  e = cut_exp<T>(x > T(20) ? most : x);
  return e * (e + T(2));
}

template <class T, CurveKind K>
inline Register<T> curve_lanes(const Curve<T>& curve, const Register<T>& x) {
  if constexpr (K == CurveKind::logistic) {
    return logistic_lanes<T>(x);
  } else if constexpr (K == CurveKind::swish) {
    return x * logistic_lanes<T>(x);
  } else if constexpr (K == CurveKind::mish) {
    Register<T> e;
    const Register<T> n = mish_term<T>(x, e);
    return x * (n / (n + T(2)));
  } else if constexpr (K == CurveKind::hard_logistic) {
    return unit_lanes<T>(x * curve.a + curve.b);
  } else if constexpr (K == CurveKind::hard_swish) {
    return x * unit_lanes<T>(x * curve.a + curve.b);
  } else {
    const Register<T> low = curve.a + Register<T>{}, high = curve.b + Register<T>{};
    const Register<T> above = x < low ? low : x;
    return above > high ? high : above;
  }
}

/// Its derivative.
template <class T, CurveKind K>
inline Register<T> curve_slope_lanes(const Curve<T>& curve, const Register<T>& x) {
  const Register<T> zero = {}, one = T(1) + zero;
  if constexpr (K == CurveKind::logistic) {
    const Register<T> s = logistic_lanes<T>(x);
    return s * logistic_lanes<T>(-x);
  } else if constexpr (K == CurveKind::swish) {
    const Register<T> s = logistic_lanes<T>(x);
    return s * (x * logistic_lanes<T>(-x) + T(1));
  } else if constexpr (K == CurveKind::mish) {
    Register<T> e;
    const Register<T> n = mish_term<T>(x, e), sum = n + T(2);
    // (1 − t²) · σ(x) with 1 − t² = (4n + 4)/(n + 2)² and σ(x) = e/(e + 1)
    const Register<T> slope = n / sum + x * (e / (e + T(1))) * (n * T(4) + T(4)) / (sum * sum);
    return x > T(20) ? one : slope;
  } else if constexpr (K == CurveKind::hard_logistic) {
    const Register<T> y = x * curve.a + curve.b, slope = curve.a + zero;
    return ((y > T(0)) & (y < T(1))) ? slope : zero;
  } else if constexpr (K == CurveKind::hard_swish) {
    const Register<T> y = x * curve.a + curve.b, flat = unit_lanes<T>(y);
    return ((y > T(0)) & (y < T(1))) ? y + x * curve.a : flat;
  } else {
    return ((x > curve.a) & (x < curve.b)) ? one : zero;
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

template <class T, CurveKind K>
void apply_one_curve(const Curve<T>& curve, const T* from, T* to, std::size_t count) {
  const Curve<T> own = curve;
  for (std::size_t i = 0; i < count; i += Vector<T>::lanes)
    store_lanes<T>(curve_lanes<T, K>(own, load_lanes<T>(from + i, count - i)), to + i, count - i);
}

/// to[i] = curve(from[i]); both may be the same
template <class T>
void apply_curve(const Curve<T>& curve, const T* from, T* to, std::size_t count) {
  TAPESTRY_BY_CURVE(curve.kind, apply_one_curve, curve, from, to, count)
}

template <class T, CurveKind K>
void one_curve_adjoint(const Curve<T>& curve, const T* argument, const T* from, T* to, std::size_t count) {
  const Curve<T> own = curve;
  for (std::size_t i = 0; i < count; i += Vector<T>::lanes) {
    const Register<T> slope = curve_slope_lanes<T, K>(own, load_lanes<T>(argument + i, count - i));
    store_lanes<T>(slope * load_lanes<T>(from + i, count - i), to + i, count - i);
  }
}

/// to[i] = curve'(argument[i]) · from[i]; `from` and `to` may be the same
template <class T>
void curve_adjoint(const Curve<T>& curve, const T* argument, const T* from, T* to, std::size_t count) {
  TAPESTRY_BY_CURVE(curve.kind, one_curve_adjoint, curve, argument, from, to, count)
}

/// store_any() for an epilogue with a curve.
template <class T, CurveKind K>
__attribute__((noinline)) void store_one_curve(const Epilogue<T>& from, const Register<T>* sums,
                                               std::size_t rows, std::size_t registers, std::size_t first,
                                               T* out, std::ptrdiff_t step, std::size_t count) {
  constexpr std::size_t lanes = Vector<T>::lanes;
  const Epilogue<T> end = from;  // a copy, which stores cannot change
  for (std::size_t row = 0; row < rows; ++row, out += step, sums += registers) {
    const std::ptrdiff_t offset = end.origin == nullptr ? 0 : out - end.origin;
    for (std::size_t v = 0; v * lanes < count && v < registers; ++v) {
      const std::size_t left = count - v * lanes;
      const std::size_t place = static_cast<std::size_t>(offset) + v * lanes;
      Register<T> value = sums[v];
      if (end.bias != nullptr) value += load(end.bias + first + v * lanes);
      if (end.adds) value += load_lanes<T>(out + v * lanes, left);
      if (end.argument != nullptr) store_lanes<T>(value, end.argument + place, left);
      value = curve_lanes<T, K>(end.curve, value);
      if (end.addend != nullptr) value += load_lanes<T>(end.addend + place, left);
      store_lanes<T>(value, out + v * lanes, left);
    }
  }
}

template <class T>
inline void store_curved(const Epilogue<T>& end, const Register<T>* sums, std::size_t rows,
                         std::size_t registers, std::size_t first, T* out, std::ptrdiff_t step,
                         std::size_t count) {
  TAPESTRY_BY_CURVE(end.curve.kind, store_one_curve, end, sums, rows, registers, first, out, step, count)
}

#undef TAPESTRY_BY_CURVE

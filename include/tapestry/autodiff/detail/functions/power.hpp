#pragma once
#include <tapestry/autodiff/detail/functions/scalar_functions.hpp>
#include <tapestry/autodiff/detail/tape/formula.hpp>

namespace tapestry {
namespace detail {
struct Square {
  static constexpr bool is_cheap = true;
  static auto value(auto x) { return x * x; }
  static auto partial(auto x, auto) { return 2 * x; }
};
struct Sqrt {
  static constexpr bool is_cheap = true;
  static bool is_kink(auto x) { return x == 0; }
  static auto value(auto x) { return sqrt(x); }
  static auto partial(auto, auto sqrt_x) { return 1 / (2 * sqrt_x); }
  static auto curvature(auto x, auto, auto slope) { return -slope / (2 * x); }
};
struct Cbrt {
  static bool is_kink(auto x) { return x == 0; }
  static auto value(auto x) { return cbrt(x); }
  static auto partial(auto x, auto cbrt_x) { return cbrt_slope(x, cbrt_x); }
  static auto curvature(auto x, auto, auto slope) { return -2 * slope / (3 * x); }
};
template <std::floating_point T>
[[nodiscard]] bool is_normal_number(T x) {
  return std::abs(x) >= std::numeric_limits<T>::min() && std::isfinite(x);
}

template <Scalar T>
[[nodiscard]] auto number_of(const T& x) {
  return value_of<Base<T>>(x);
}

/// x^y / x^n · factor for x > 0, where x^y may be denormal, 0 or ∞ though the result is not: by x^(y/2),
/// twice.
/// \returns whether x^(y/2) is a normal number, so that the result, in `product`, is right
template <Scalar T>
[[nodiscard]] bool lowered_power(const T& x, const T& y, int n, const T& factor, T& product) {
  const T half = pow(x, y / 2);
  if (!is_normal_number(number_of(half))) return false;
  T lower = half, upper = half;
  for (int k = 0; k < n; ++k) (k % 2 == 0 ? lower : upper) = (k % 2 == 0 ? lower : upper) / x;
  const bool grows = std::abs(number_of(factor)) > 1, lower_is_less = number_of(lower) < number_of(upper);
  T& scaled = grows == lower_is_less ? lower : upper;  // overflows or vanishes only if the result does
  scaled = scaled * factor;
  product = lower * upper;
  return true;
}

/// The N-th derivative of x^y by x, y (y − 1) … (y − N + 1) · x^(y − N), given the power itself.
template <int N>
struct PowSlope {
  template <std::floating_point T>
  static T value(T x, T y, T power) {
    T factor = 1, slope = power;
    for (int k = 0; k < N; ++k) {
      const T ratio = (y - static_cast<T>(k)) / x;
      factor *= y - static_cast<T>(k);
      slope = is_normal_number(ratio) ? slope * ratio : slope / x * (y - static_cast<T>(k));
    }
    if (factor == 0 || (power == 0 && std::isinf(y))) return T(0);
    if (std::isnan(power) || (x != 0 && is_normal_number(power) && is_normal_number(slope))) return slope;
    T size = 0;  // the power is 0, ∞ or lost digits; its slope may be sound
    if (lowered_power(std::abs(x), y, N, factor, size))
      return x < 0 && std::signbit(power) == (N % 2 == 0) ? -size : size;
    return factor * std::pow(x, y - T(N));
  }
  template <DualNumber D>
  static D value(const D& x, const D& y, const D& power) {
    const auto slope = value(x.value(), y.value(), power.value());
    D result = dual_of<PowSlope>(x, slope, PowSlope<N + 1>::value(x.value(), y.value(), power.value()));
    if (D(0, y.tangents()).is_zero()) return result;
    return result + dual_of<PowSlope>(D(0, y.tangents()), decltype(slope)(0),
                                      by_exponent(x.value(), y.value(), power.value()));
  }

  /// The derivative of the slope by y, (f′(y) + f(y) · log x) · x^(y − N), where f is the factor.
  template <Scalar T>
  static T by_exponent(const T& x, const T& y, const T& power) {
    T factor = 1, by_y = 0, lowered = power;
    for (int k = 0; k < N; ++k) {
      by_y = by_y * (y - k) + factor;
      factor = factor * (y - k);
      lowered = lowered / x;
    }
    if (x == 0 && (y == 0 || y >= N)) return y == N ? by_y : T(0);
    if (power == 0 && (x < 0 || !isfinite(x) || !isfinite(y))) return T(0);
    const T slope = by_y + factor * log(x);
    if (x == 0) return pow(x, y - N) * slope;
    if (is_normal_number(number_of(power)) && is_normal_number(number_of(lowered))) return lowered * slope;
    T product(0);
    return x > 0 && lowered_power(x, y, N, slope, product) ? product : pow(x, y - N) * slope;
  }
};
struct Pow {
  static constexpr bool skips_zero = true;
  /// Points where the slope by x or its derivative is infinite; the slope by y is infinite there, too.
  static bool is_kink(auto x, auto y) { return x == 0 && y < 2 && !(y == 0 || y == 1); }
  static auto value(auto x, auto y) { return pow(x, y); }
  static auto partial_x(auto x, auto y, auto pow_xy) { return PowSlope<1>::value(x, y, pow_xy); }
  template <std::floating_point T>
  static T partial_y(T x, T y, T pow_xy) {
    return times(x, y, pow_xy, std::log(x));
  }
  template <DualNumber D>
  static D partial_y(const D& x, const D& y, const D& pow_xy) {
    if (x == 0 && (pow_xy == 0 || y == 0)) return D(0);
    if (x == 0) return x.is_zero() ? D(pow_xy * log(number_of(x))) : D(pow_xy * log(x));
    using T = typename D::value_type;
    const T a = x.value(), b = y.value(), power = pow_xy.value(), log_a = log(a);
    D slope(partial_y(a, b, power));
    if (!D(0, x.tangents()).is_zero())
      slope += dual_of<Pow>(D(0, x.tangents()), T(0), PowSlope<1>::by_exponent(a, b, power));
    if (!D(0, y.tangents()).is_zero())
      slope += dual_of<Pow>(D(0, y.tangents()), T(0), times(a, b, power, T(log_a * log_a)));
    return slope;
  }

 private:
  /// x^y · factor, 0 where the power is exactly 0, and at x = y = 0.
  template <Scalar T>
  static T times(const T& x, const T& y, const T& pow_xy, const T& factor) {
    if (x == 0 && y == 0) return T(0);
    if (is_normal_number(number_of(pow_xy))) return pow_xy * factor;
    T product(0);
    if (x > 0 && lowered_power(x, y, 0, factor, product)) return product;
    return pow_xy == 0 ? T(0) : T(pow_xy * factor);
  }
};

/// x · 2^n, where n is an integer.
struct Ldexp {
  static auto value(std::floating_point auto x, auto n) { return std::ldexp(x, static_cast<int>(n)); }
  static auto value(DualNumber auto x, auto n) { return dual_binary<Ldexp, decltype(x)>(x, n); }
  static auto partial_x(auto x, auto n, auto) { return value(decltype(x)(1), n); }
  static auto partial_y(auto x, auto, auto) { return decltype(x)(0); }
};

template <Scalar T, std::size_t N>
[[nodiscard]] T length_of(const std::array<T, N>& legs) {
  if constexpr (N == 2) {
    return hypot(legs[0], legs[1]);
  } else {
    return hypot(legs[0], legs[1], legs[2]);
  }
}

/// Factor for legs, so that their length neither overflows nor loses digits.
template <std::floating_point T>
[[nodiscard]] T scale_of_length(T length) {
  return length < std::numeric_limits<T>::min()   ? T(0x1p64F)
         : length > std::numeric_limits<T>::max() ? T(0.25F)
                                                  : T(1);
}

/// Legs by their length; 0 at the origin, and ±1 for a leg that is infinite.
template <std::floating_point T, std::size_t N>
[[nodiscard]] std::array<T, N> direction(std::array<T, N> legs, T length) {
  if (length == 0) return {};
  if (const T scale = scale_of_length(length); scale != 1) {
    for (T& leg : legs) leg *= scale;
    length = length_of(legs);
  }
  for (T& leg : legs) leg = std::isinf(leg) ? std::copysign(T(1), leg) : leg / length;
  return legs;
}
/// A leg's slope by itself is the sum of the other legs' squares by the length. The form 1
/// − its square would cancel.
template <DualNumber D, std::size_t N>
[[nodiscard]] std::array<D, N> direction(const std::array<D, N>& legs, const D& length) {
  using T = typename D::value_type;
  std::array<T, N> values;
  for (std::size_t i = 0; i < N; ++i) values[i] = legs[i].value();
  const std::array<T, N> unit = direction(values, length.value());
  const auto scale = scale_of_length(number_of(length));
  T scaled_length = length.value();
  if (scale != 1) {
    for (T& value : values) value = value * scale;
    scaled_length = length_of(values);
  }
  const auto curvature = [&](const T& a, const T& b) {  // an infinite quotient would meet a leg of 0
    const bool is_less = abs(a) < abs(b);
    return (is_less ? b : a) * ((is_less ? a : b) / scaled_length) * scale;
  };
  std::array<D, N> result;
  for (std::size_t i = 0; i < N; ++i) {
    result[i] = unit[i];
    T by_own = 0;
    for (std::size_t j = 0; j < N && length != 0; ++j) {
      if (j == i) continue;
      by_own += curvature(unit[j], unit[j]);
      result[i] += dual_of<Square>(D(0, legs[j].tangents()), T(0), -curvature(unit[i], unit[j]));
    }
    result[i] += dual_of<Square>(D(0, legs[i].tangents()), T(0), by_own);
    result[i] = slope_at_kink(length == 0, result[i]);
  }
  return result;
}
struct Hypot {
  static constexpr bool skips_zero = true;
  static auto value(auto x, auto y) {
    return value_at_kink(x == 0 && y == 0, decltype(x)(hypot(x, y)), x, y);
  }
  static auto partial_x(auto x, auto y, auto length) { return direction(std::array{x, y}, length)[0]; }
  static auto partial_y(auto x, auto y, auto length) { return direction(std::array{x, y}, length)[1]; }
};
}  // namespace detail

/// x · x, evaluating x once.
template <int = 0, detail::Argument X>
[[nodiscard]] auto square(const X& x) {
  return detail::make_unary<detail::Square>(x);
}

/// x · 2^exponent, rounded once.
template <Differentiable X>
[[nodiscard]] auto ldexp(const X& x, int exponent) {
  constexpr int most = 1 << 16;  // beyond any power of two, and a number of any type
  return detail::make_binary<detail::Ldexp>(x, exponent > most ? most : exponent < -most ? -most : exponent);
}

/// x · 2^−n of a size in [½, 1), and n, for x = 0 and x not finite x itself, and 0. The derivative is 2^−n,
/// which is constant between powers of two.
/// \param exponent  receives n
template <Differentiable X>
[[nodiscard]] auto frexp(const X& x, int* exponent) {
  const auto number = detail::base_value(x);
  *exponent = 0;
  if (std::isfinite(number)) static_cast<void>(std::frexp(number, exponent));
  return ldexp(x, -*exponent);
}

/// At 0 the derivative is +∞; it does no harm where the adjoint is zero.
[[nodiscard]] auto sqrt(const detail::Argument auto& x) { return detail::make_unary<detail::Sqrt>(x); }

/// At 0 the derivative is +∞.
[[nodiscard]] auto cbrt(const detail::Argument auto& x) { return detail::make_unary<detail::Cbrt>(x); }

/// x to the power of y, as std::pow; pow(0, 0) = 1. d/dx = y · x^(y−1), and 0 for y = 0 whatever x is. d/dy =
/// x^y · log x; it is 0 where the power is 0 and at pow(0, 0), −∞ for x = 0 > y, and NaN for x < 0, where
/// neighbouring powers do not exist: let the exponent be passive there. A passive operand costs nothing.
template <class X, class Y>
requires detail::Arguments<X, Y>
[[nodiscard]] auto pow(const X& x, const Y& y) { return detail::make_binary<detail::Pow>(x, y, "pow"); }

/// √(x² + y²) without overflow. At the origin both derivatives are 0, a subgradient.
template <class X, class Y>
requires detail::Arguments<X, Y>
[[nodiscard]] auto hypot(const X& x, const Y& y) { return detail::make_binary<detail::Hypot>(x, y, "hypot"); }
}  // namespace tapestry

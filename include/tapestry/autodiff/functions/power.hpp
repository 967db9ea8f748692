#pragma once
#include <limits>
#include <tapestry/autodiff/functions/scalar_functions.hpp>
#include <tapestry/autodiff/tape/expression.hpp>
#include <tapestry/autodiff/tape/formula.hpp>

namespace tapestry {
namespace detail {
struct Square {
  static constexpr bool is_cheap = true;
  static auto value(auto x) { return x * x; }
  static auto partial(auto x, auto) { return 2 * x; }
};
struct Sqrt {
  static constexpr bool is_cheap = true;
  static auto value(auto x) { return sqrt(x); }
  static auto partial(auto, auto sqrt_x) { return 1 / (2 * sqrt_x); }
};
struct Cbrt {
  static auto value(auto x) { return cbrt(x); }
  template <std::floating_point T>
  static T partial(T x, T cbrt_x) {
    return cbrt_slope(x, cbrt_x);
  }
  template <DualNumber T>
  static T partial(const T& x, const T& cbrt_x) {
    const auto slope = partial(x.value(), cbrt_x.value());
    return dual_of<Cbrt>(x, slope, -2 * slope / (3 * x.value()));
  }
};
struct Pow {
  static constexpr bool skips_zero = true;
  static auto value(auto x, auto y) { return pow(x, y); }
  static auto partial_x(auto x, auto y, auto pow_xy) {
    if (is_zero(y) || (x == 0 && y == 0)) return decltype(x)(0);
    if (x != 0 && is_normal(pow_xy)) return pow_xy * (y / x);
    return y * pow(x, y - 1);  // the power itself is 0 or ∞, or lost digits, where its slope need not
  }
  static auto partial_y(auto x, auto y, auto pow_xy) {
    if (pow_xy == 0 || (x == 0 && y == 0)) return decltype(x)(0);
    return pow_xy * log(x);
  }

 private:
  static bool is_normal(auto x) {
    return abs(x) >= std::numeric_limits<Base<decltype(x)>>::min() && isfinite(x);
  }
};
struct Hypot {
  static constexpr bool skips_zero = true;
  static auto value(auto x, auto y) { return hypot(x, y); }
  static auto partial_x(auto x, auto, auto length) { return direction(x, length); }
  static auto partial_y(auto, auto y, auto length) { return direction(y, length); }

  static auto direction(auto leg, auto length) {
    using T = decltype(leg);
    if (length == 0) return T(0);
    if (isinf(leg)) return T(leg > 0 ? 1 : -1);
    return leg / length;
  }
};
}  // namespace detail

/// x · x, evaluating x once.
template <Differentiable X>
[[nodiscard]] auto square(const X& x) {
  return detail::make_unary<detail::Square>(x);
}

/// At 0 the derivative is +∞; it does no harm to what has a zero adjoint there.
template <Differentiable X>
[[nodiscard]] auto sqrt(const X& x) {
  return detail::make_unary<detail::Sqrt>(x);
}

/// At 0 the derivative is +∞.
template <Differentiable X>
[[nodiscard]] auto cbrt(const X& x) {
  return detail::make_unary<detail::Cbrt>(x);
}

/// x to the power of y, as std::pow; pow(0, 0) = 1.
/// d/dx = y · x^(y−1), and 0 for y = 0 whatever x is. d/dy = x^y · log x; it is 0 where the power is 0
/// and at pow(0, 0), −∞ for x = 0 > y, and NaN for x < 0, where neighbouring powers do not exist: let the
/// exponent be passive there. A passive operand costs nothing.
template <class X, class Y>
requires detail::FormulaOperands<X, Y>
[[nodiscard]] auto pow(const X& x, const Y& y) { return detail::make_binary<detail::Pow>(x, y); }

/// √(x² + y²) without overflow. At the origin both derivatives are 0, a subgradient.
template <class X, class Y>
requires detail::FormulaOperands<X, Y>
[[nodiscard]] auto hypot(const X& x, const Y& y) { return detail::make_binary<detail::Hypot>(x, y); }

}  // namespace tapestry

#pragma once
#include <cmath>
#include <numbers>
#include <tapestry/autodiff/expression.hpp>

namespace tapestry {
namespace detail {
struct Square {
  static auto value(auto x) { return x * x; }
  static auto partial(auto x, auto) { return 2 * x; }
};
struct Sqrt {
  static auto value(auto x) { return std::sqrt(x); }
  static auto partial(auto, auto sqrt_x) { return 1 / (2 * sqrt_x); }
};
struct Cbrt {
  static auto value(auto x) { return std::cbrt(x); }
  static auto partial(auto, auto cbrt_x) { return 1 / (3 * cbrt_x * cbrt_x); }
};
struct Pow {
  static constexpr bool skips_zero = true;
  static auto value(auto x, auto y) { return std::pow(x, y); }
  static auto partial_x(auto x, auto y, auto pow_xy) {
    if (y == 0) return decltype(x)(0);
    if (x != 0 && std::isnormal(pow_xy)) return pow_xy * (y / x);
    return y * std::pow(x, y - 1);  // the power itself is 0 or ∞, or lost digits, where its slope need not
  }
  static auto partial_y(auto x, auto y, auto pow_xy) {
    if (pow_xy == 0 || (x == 0 && y == 0)) return decltype(x)(0);
    return pow_xy * std::log(x);
  }
};
struct Hypot {
  static constexpr bool skips_zero = true;
  static auto value(auto x, auto y) { return std::hypot(x, y); }
  static auto partial_x(auto x, auto, auto length) { return direction(x, length); }
  static auto partial_y(auto, auto y, auto length) { return direction(y, length); }

 private:
  static auto direction(auto leg, auto length) {
    if (length == 0) return decltype(leg)(0);
    if (std::isinf(leg)) return std::copysign(decltype(leg)(1), leg);
    return leg / length;
  }
};
struct Erf {
  static auto value(auto x) { return std::erf(x); }
  static auto partial(auto x, auto) { return 2 * std::numbers::inv_sqrtpi_v<decltype(x)> * std::exp(-x * x); }
};
struct Erfc {
  static auto value(auto x) { return std::erfc(x); }
  static auto partial(auto x, auto) { return -Erf::partial(x, x); }
};
}  // namespace detail

/// x · x, evaluating x once.
template <ScalarExpression X>
[[nodiscard]] auto square(const X& x) {
  return detail::make_unary<detail::Square>(x);
}

/// At 0 the derivative is +∞; it does no harm to what has a zero adjoint there.
template <ScalarExpression X>
[[nodiscard]] auto sqrt(const X& x) {
  return detail::make_unary<detail::Sqrt>(x);
}

/// At 0 the derivative is +∞.
template <ScalarExpression X>
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

template <ScalarExpression X>
[[nodiscard]] auto erf(const X& x) {
  return detail::make_unary<detail::Erf>(x);
}

template <ScalarExpression X>
[[nodiscard]] auto erfc(const X& x) {
  return detail::make_unary<detail::Erfc>(x);
}

}  // namespace tapestry

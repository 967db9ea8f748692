#pragma once
#include <cmath>
#include <tapestry/autodiff/expression.hpp>

namespace tapestry {
namespace detail {
struct Sin {
  static auto value(auto x) { return std::sin(x); }
  static auto partial(auto x, auto) { return std::cos(x); }
};
struct Cos {
  static auto value(auto x) { return std::cos(x); }
  static auto partial(auto x, auto) { return -std::sin(x); }
};
struct Tan {
  static auto value(auto x) { return std::tan(x); }
  static auto partial(auto, auto tan_x) { return 1 + tan_x * tan_x; }
};
struct Asin {
  static auto value(auto x) { return std::asin(x); }
  static auto partial(auto x, auto) { return 1 / std::sqrt((1 - x) * (1 + x)); }
};
struct Acos {
  static auto value(auto x) { return std::acos(x); }
  static auto partial(auto x, auto) { return -1 / std::sqrt((1 - x) * (1 + x)); }
};
struct Atan {
  static auto value(auto x) { return std::atan(x); }
  static auto partial(auto x, auto) { return 1 / (1 + x * x); }
};
struct Atan2 {
  static constexpr bool skips_zero = true;
  static auto value(auto y, auto x) { return std::atan2(y, x); }
  static auto partial_x(auto y, auto x, auto) { return scaled(x, std::hypot(y, x)); }
  static auto partial_y(auto y, auto x, auto) { return scaled(-y, std::hypot(y, x)); }

 private:
  static auto scaled(auto leg, auto radius) { return radius == 0 ? decltype(leg)(0) : leg / radius / radius; }
};
}  // namespace detail

template <ScalarExpression X>
[[nodiscard]] auto sin(const X& x) {
  return detail::make_unary<detail::Sin>(x);
}

template <ScalarExpression X>
[[nodiscard]] auto cos(const X& x) {
  return detail::make_unary<detail::Cos>(x);
}

template <ScalarExpression X>
[[nodiscard]] auto tan(const X& x) {
  return detail::make_unary<detail::Tan>(x);
}

/// At ±1 the derivative is +∞.
template <ScalarExpression X>
[[nodiscard]] auto asin(const X& x) {
  return detail::make_unary<detail::Asin>(x);
}

/// At ±1 the derivative is −∞.
template <ScalarExpression X>
[[nodiscard]] auto acos(const X& x) {
  return detail::make_unary<detail::Acos>(x);
}

template <ScalarExpression X>
[[nodiscard]] auto atan(const X& x) {
  return detail::make_unary<detail::Atan>(x);
}

/// Angle of the point (x, y). At the origin, and across the cut, where the angle jumps, the derivatives
/// are those of the smooth branch; at the origin itself they are taken as 0.
template <class Y, class X>
requires detail::FormulaOperands<Y, X>
[[nodiscard]] auto atan2(const Y& y, const X& x) { return detail::make_binary<detail::Atan2>(y, x); }

}  // namespace tapestry

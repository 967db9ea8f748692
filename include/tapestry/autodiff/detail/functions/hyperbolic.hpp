#pragma once
#include <tapestry/autodiff/detail/functions/scalar_functions.hpp>
#include <tapestry/autodiff/detail/tape/formula.hpp>

namespace tapestry {
namespace detail {
struct Sinh {
  static auto value(auto x) { return sinh(x); }
  static auto partial(auto x, auto) { return cosh(x); }
};
struct Cosh {
  static auto value(auto x) { return cosh(x); }
  static auto partial(auto x, auto) { return sinh(x); }
};
struct Tanh {
  static auto value(auto x) { return tanh(x); }
  static auto value(double x) { return tanh_of(x); }
  static auto partial(auto x, auto tanh_x) { return tanh_slope(x, tanh_x); }
  static auto curvature(auto, auto tanh_x, auto slope) { return -2 * tanh_x * slope; }
};
struct Asinh {
  static auto value(auto x) { return asinh(x); }
  static auto partial(auto x, auto) { return 1 / hypot(decltype(x)(1), x); }
};
struct Acosh {
  static bool is_kink(auto x) { return x == 1; }
  static auto value(auto x) { return acosh(x); }
  static auto partial(auto x, auto) { return 1 / (sqrt(x - 1) * sqrt(x + 1)); }
};
struct Atanh {
  static bool is_kink(auto x) { return x == 1 || x == -1; }
  static auto value(auto x) { return atanh(x); }
  static auto partial(auto x, auto) { return 1 / ((1 - x) * (1 + x)); }
  static auto curvature(auto x, auto, auto slope) { return 2 * x * slope * slope; }
};
}  // namespace detail

[[nodiscard]] auto sinh(const detail::Argument auto& x) { return detail::make_unary<detail::Sinh>(x); }
[[nodiscard]] auto cosh(const detail::Argument auto& x) { return detail::make_unary<detail::Cosh>(x); }

/// The derivative keeps its relative precision in saturation, until it underflows.
[[nodiscard]] auto tanh(const detail::Argument auto& x) { return detail::make_unary<detail::Tanh>(x); }
[[nodiscard]] auto asinh(const detail::Argument auto& x) { return detail::make_unary<detail::Asinh>(x); }

/// At 1 the derivative is +∞.
[[nodiscard]] auto acosh(const detail::Argument auto& x) { return detail::make_unary<detail::Acosh>(x); }

/// At ±1 value and derivative are infinite.
[[nodiscard]] auto atanh(const detail::Argument auto& x) { return detail::make_unary<detail::Atanh>(x); }
}  // namespace tapestry

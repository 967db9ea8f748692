#pragma once
#include <cmath>
#include <tapestry/autodiff/expression.hpp>
#include <tapestry/autodiff/scalar_functions.hpp>

namespace tapestry {
namespace detail {
struct Sinh {
  static auto value(auto x) { return std::sinh(x); }
  static auto partial(auto x, auto) { return std::cosh(x); }
};
struct Cosh {
  static auto value(auto x) { return std::cosh(x); }
  static auto partial(auto x, auto) { return std::sinh(x); }
};
struct Tanh {
  static auto value(auto x) { return std::tanh(x); }
  static auto partial(auto x, auto tanh_x) { return tanh_derivative(x, tanh_x); }
};
struct Asinh {
  static auto value(auto x) { return std::asinh(x); }
  static auto partial(auto x, auto) { return 1 / std::hypot(decltype(x)(1), x); }
};
struct Acosh {
  static auto value(auto x) { return std::acosh(x); }
  static auto partial(auto x, auto) { return 1 / (std::sqrt(x - 1) * std::sqrt(x + 1)); }
};
struct Atanh {
  static auto value(auto x) { return std::atanh(x); }
  static auto partial(auto x, auto) { return 1 / ((1 - x) * (1 + x)); }
};
}  // namespace detail

template <ScalarExpression X>
[[nodiscard]] auto sinh(const X& x) {
  return detail::make_unary<detail::Sinh>(x);
}

template <ScalarExpression X>
[[nodiscard]] auto cosh(const X& x) {
  return detail::make_unary<detail::Cosh>(x);
}

/// The derivative keeps its relative precision in saturation, until it underflows.
template <ScalarExpression X>
[[nodiscard]] auto tanh(const X& x) {
  return detail::make_unary<detail::Tanh>(x);
}

template <ScalarExpression X>
[[nodiscard]] auto asinh(const X& x) {
  return detail::make_unary<detail::Asinh>(x);
}

/// At 1 the derivative is +∞.
template <ScalarExpression X>
[[nodiscard]] auto acosh(const X& x) {
  return detail::make_unary<detail::Acosh>(x);
}

/// At ±1 value and derivative are infinite.
template <ScalarExpression X>
[[nodiscard]] auto atanh(const X& x) {
  return detail::make_unary<detail::Atanh>(x);
}

}  // namespace tapestry

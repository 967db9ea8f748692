#pragma once
#include <tapestry/autodiff/detail/functions/scalar_functions.hpp>
#include <tapestry/autodiff/detail/tape/expression.hpp>
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
  template <std::floating_point T>
  static T partial(T x, T tanh_x) {
    return tanh_slope(x, tanh_x);
  }
  template <DualNumber T>
  static T partial(const T& x, const T& tanh_x) {
    const auto slope = partial(x.value(), tanh_x.value());
    return dual_of<Tanh>(x, slope, -2 * tanh_x.value() * slope);
  }
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
  template <std::floating_point T>
  static T partial(T x, T) {
    return 1 / ((1 - x) * (1 + x));
  }
  /// The slope is given, since the product of the two factors would cancel near 0.
  template <DualNumber T>
  static T partial(const T& x, const T& atanh_x) {
    const auto f = partial(x.value(), atanh_x.value());
    return dual_of<Atanh>(x, f, 2 * x.value() * f * f);
  }
};
}  // namespace detail

template <Differentiable X>
[[nodiscard]] auto sinh(const X& x) {
  return detail::make_unary<detail::Sinh>(x);
}

template <Differentiable X>
[[nodiscard]] auto cosh(const X& x) {
  return detail::make_unary<detail::Cosh>(x);
}

/// The derivative keeps its relative precision in saturation, until it underflows.
template <Differentiable X>
[[nodiscard]] auto tanh(const X& x) {
  return detail::make_unary<detail::Tanh>(x);
}

template <Differentiable X>
[[nodiscard]] auto asinh(const X& x) {
  return detail::make_unary<detail::Asinh>(x);
}

/// At 1 the derivative is +∞.
template <Differentiable X>
[[nodiscard]] auto acosh(const X& x) {
  return detail::make_unary<detail::Acosh>(x);
}

/// At ±1 value and derivative are infinite.
template <Differentiable X>
[[nodiscard]] auto atanh(const X& x) {
  return detail::make_unary<detail::Atanh>(x);
}

}  // namespace tapestry

#pragma once
#include <cmath>
#include <tapestry/autodiff/expression.hpp>

namespace tapestry {
namespace detail {
struct Abs {
  static constexpr bool skips_zero = true;
  static auto value(auto x) { return std::abs(x); }
  static auto partial(auto x, auto) { return x > 0 ? decltype(x)(1) : x < 0 ? decltype(x)(-1) : x; }
};
struct Max {
  static constexpr bool skips_zero = true;
  static auto value(auto x, auto y) { return takes_x(x, y) ? x : y; }
  static auto partial_x(auto x, auto y, auto) { return decltype(x)(takes_x(x, y) ? 1 : 0); }
  static auto partial_y(auto x, auto y, auto) { return decltype(x)(takes_x(x, y) ? 0 : 1); }

 private:
  static bool takes_x(auto x, auto y) { return x >= y || std::isnan(x); }
};
struct Min {
  static constexpr bool skips_zero = true;
  static auto value(auto x, auto y) { return takes_x(x, y) ? x : y; }
  static auto partial_x(auto x, auto y, auto) { return decltype(x)(takes_x(x, y) ? 1 : 0); }
  static auto partial_y(auto x, auto y, auto) { return decltype(x)(takes_x(x, y) ? 0 : 1); }

 private:
  static bool takes_x(auto x, auto y) { return x <= y || std::isnan(x); }
};
struct Fmod {
  static constexpr bool skips_zero = true;
  static auto value(auto x, auto y) { return std::fmod(x, y); }
  static auto partial_x(auto x, auto, auto) { return decltype(x)(1); }
  static auto partial_y(auto x, auto y, auto) { return -std::trunc(x / y); }
};
}  // namespace detail

/// |x|; its derivative at 0 is taken as 0.
template <ScalarExpression X>
[[nodiscard]] auto abs(const X& x) {
  return detail::make_unary<detail::Abs>(x);
}
template <ScalarExpression X>
[[nodiscard]] auto fabs(const X& x) {
  return detail::make_unary<detail::Abs>(x);
}

/// The larger one, and its derivative. At a tie the first argument has the whole derivative. A NaN on
/// either side gives NaN. The argument not taken receives no gradient, whatever is upstream.
template <class X, class Y>
requires detail::FormulaOperands<X, Y>
[[nodiscard]] auto max(const X& x, const Y& y) { return detail::make_binary<detail::Max>(x, y); }

/// The smaller one; otherwise as max().
template <class X, class Y>
requires detail::FormulaOperands<X, Y>
[[nodiscard]] auto min(const X& x, const Y& y) { return detail::make_binary<detail::Min>(x, y); }

/// x held within [low, high]. The derivative by x is 1 on the closed interval and 0 outside.
template <ScalarExpression X, Number N>
[[nodiscard]] auto clamp(const X& x, N low, N high) {
  return min(max(x, low), high);
}

/// As std::fmod; the derivatives are those between its jumps: 1, and −trunc(x / y).
template <class X, class Y>
requires detail::FormulaOperands<X, Y>
[[nodiscard]] auto fmod(const X& x, const Y& y) { return detail::make_binary<detail::Fmod>(x, y); }

/// Functions constant between jumps have no derivative to record and return a plain number.
template <ScalarExpression X>
[[nodiscard]] auto floor(const X& x) {
  return std::floor(x.value());
}
template <ScalarExpression X>
[[nodiscard]] auto ceil(const X& x) {
  return std::ceil(x.value());
}
template <ScalarExpression X>
[[nodiscard]] auto round(const X& x) {
  return std::round(x.value());
}
template <ScalarExpression X>
[[nodiscard]] auto trunc(const X& x) {
  return std::trunc(x.value());
}

template <ScalarExpression X>
[[nodiscard]] bool isfinite(const X& x) {
  return std::isfinite(x.value());
}
template <ScalarExpression X>
[[nodiscard]] bool isinf(const X& x) {
  return std::isinf(x.value());
}
template <ScalarExpression X>
[[nodiscard]] bool isnan(const X& x) {
  return std::isnan(x.value());
}

}  // namespace tapestry

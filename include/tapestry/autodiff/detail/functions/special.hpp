#pragma once
#include <tapestry/autodiff/detail/functions/polygamma.hpp>
#include <tapestry/autodiff/detail/functions/scalar_functions.hpp>
#include <tapestry/autodiff/detail/tape/formula.hpp>

namespace tapestry {
namespace detail {
/// exp(−x²), corrected by the rounding error of x²: at x = 26 that is hundreds of ulp.
struct ExpMinusSquare {
  template <std::floating_point T>
  static T value(T x) {
    const T squared = x * x;
    const T e = std::exp(-squared);
    return e == 0 ? e : e * (1 - std::fma(x, x, -squared));
  }
  static auto value(DualNumber auto x) { return dual_unary<ExpMinusSquare>(x); }
  static auto partial(auto x, auto f) {
    using T = decltype(x);
    return f == 0 ? T(0) : T(-2 * x * f);  // avoids NaN from ∞ · 0
  }
};
struct Erf {
  static auto value(auto x) { return erf(x); }
  static auto partial(auto x, auto) {
    return 2 * std::numbers::inv_sqrtpi_v<Base<decltype(x)>> * ExpMinusSquare::value(x);
  }
};
struct Erfc {
  static auto value(auto x) { return erfc(x); }
  static auto partial(auto x, auto) { return -Erf::partial(x, x); }
};
template <int N>
struct Polygamma {
  static auto value(auto x) { return polygamma<N>(x); }
  static auto partial(auto x, auto) { return polygamma<N + 1>(x); }
};
struct Lgamma {
  static auto value(auto x) { return lgamma(x); }
  static auto partial(auto x, auto) { return polygamma<0>(x); }
};
struct Tgamma {
  static auto value(auto x) { return tgamma(x); }
  static auto partial(std::floating_point auto x, auto) { return gamma_derivative(x); }
  template <DualNumber T>
  static T partial(const T& x, const T& gamma_x) {
    if (x > 1 && !isfinite(gamma_x)) return gamma_x;  // below 0, ψ² outgrows the slopes of ψ
    return gamma_x * polygamma<0>(x);
  }
};
}  // namespace detail

[[nodiscard]] auto erf(const detail::Argument auto& x) { return detail::make_unary<detail::Erf>(x); }
[[nodiscard]] auto erfc(const detail::Argument auto& x) { return detail::make_unary<detail::Erfc>(x); }

/// The N-th derivative of digamma(x); see polygamma.hpp for its poles.
template <int N, detail::Argument X>
[[nodiscard]] auto polygamma(const X& x) {
  return detail::make_unary<detail::Polygamma<N>>(x);
}
template <int = 0, detail::Argument X>
[[nodiscard]] auto digamma(const X& x) {
  return detail::make_unary<detail::Polygamma<0>>(x);
}

/// log |Γ(x)|; the derivative is digamma(x), at 0 −∞ or +∞ with the side, at negative integers NaN.
[[nodiscard]] auto lgamma(const detail::Argument auto& x) { return detail::make_unary<detail::Lgamma>(x); }

/// Γ(x); at 0 the derivative is −∞, at negative integers NaN.
[[nodiscard]] auto tgamma(const detail::Argument auto& x) { return detail::make_unary<detail::Tgamma>(x); }
}  // namespace tapestry

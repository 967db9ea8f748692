#pragma once
#include <numbers>
#include <tapestry/autodiff/functions/scalar_functions.hpp>
#include <tapestry/autodiff/tape/expression.hpp>
#include <tapestry/autodiff/tape/formula.hpp>

namespace tapestry {
namespace detail {
struct Exp {
  static constexpr bool needs_only_value = true;
  static auto value(auto x) { return exp(x); }
  static auto partial(auto, auto exp_x) { return exp_x; }
};
struct Exp2 {
  static constexpr bool needs_only_value = true;
  static auto value(auto x) { return exp2(x); }
  static auto partial(auto, auto exp2_x) { return std::numbers::ln2_v<Base<decltype(exp2_x)>> * exp2_x; }
};
struct Expm1 {
  static auto value(auto x) { return expm1(x); }
  static auto partial(auto x, auto) { return exp(x); }  // expm1(x) + 1 would cancel for x ≪ 0
};
struct Log {
  static auto value(auto x) { return log(x); }
  static auto partial(auto x, auto) { return 1 / x; }
};
struct Log2 {
  static auto value(auto x) { return log2(x); }
  static auto partial(auto x, auto) { return std::numbers::log2e_v<Base<decltype(x)>> / x; }
};
struct Log10 {
  static auto value(auto x) { return log10(x); }
  static auto partial(auto x, auto) { return std::numbers::log10e_v<Base<decltype(x)>> / x; }
};
struct Log1p {
  static auto value(auto x) { return log1p(x); }
  static auto partial(auto x, auto) { return 1 / (1 + x); }
};
struct Sigmoid {
  static auto value(auto x) { return sigmoid(x); }
  static auto partial(auto x, auto) { return sigmoid_derivative(x); }
};
struct Softplus {
  static auto value(auto x) { return softplus(x); }
  static auto partial(auto x, auto) { return sigmoid(x); }
};
struct LogSumExp {
  static auto value(auto x, auto y) { return logsumexp(x, y); }
  static auto partial_x(auto x, auto y, auto) { return share(x, y); }
  static auto partial_y(auto x, auto y, auto) { return share(y, x); }

 private:
  static auto share(auto x, auto y) {
    return isinf(x) && x == y ? decltype(x)(0.5) : sigmoid_of_difference(x, y);
  }
};
}  // namespace detail

template <Differentiable X>
[[nodiscard]] auto exp(const X& x) {
  return detail::make_unary<detail::Exp>(x);
}

/// 2 to the power of x.
template <Differentiable X>
[[nodiscard]] auto exp2(const X& x) {
  return detail::make_unary<detail::Exp2>(x);
}

/// exp(x) − 1.
template <Differentiable X>
[[nodiscard]] auto expm1(const X& x) {
  return detail::make_unary<detail::Expm1>(x);
}

/// At 0 the value is −∞ and the derivative +∞; below, the value is NaN.
template <Differentiable X>
[[nodiscard]] auto log(const X& x) {
  return detail::make_unary<detail::Log>(x);
}

template <Differentiable X>
[[nodiscard]] auto log2(const X& x) {
  return detail::make_unary<detail::Log2>(x);
}

template <Differentiable X>
[[nodiscard]] auto log10(const X& x) {
  return detail::make_unary<detail::Log10>(x);
}

/// log(1 + x).
template <Differentiable X>
[[nodiscard]] auto log1p(const X& x) {
  return detail::make_unary<detail::Log1p>(x);
}

/// 1 / (1 + exp(−x)).
template <Differentiable X>
[[nodiscard]] auto sigmoid(const X& x) {
  return detail::make_unary<detail::Sigmoid>(x);
}

/// log(1 + exp(x)).
template <Differentiable X>
[[nodiscard]] auto softplus(const X& x) {
  return detail::make_unary<detail::Softplus>(x);
}

/// log(exp(x) + exp(y)). The derivatives are the softmax of (x, y); equal infinities share 1 equally.
template <class X, class Y>
requires detail::FormulaOperands<X, Y>
[[nodiscard]] auto logsumexp(const X& x, const Y& y) { return detail::make_binary<detail::LogSumExp>(x, y); }

}  // namespace tapestry

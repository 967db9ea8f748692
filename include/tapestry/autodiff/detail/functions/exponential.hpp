#pragma once
#include <numbers>
#include <tapestry/autodiff/detail/functions/scalar_functions.hpp>
#include <tapestry/autodiff/detail/tape/expression.hpp>
#include <tapestry/autodiff/detail/tape/formula.hpp>

namespace tapestry {
namespace detail {
struct Exp {
  static auto value(auto x) { return exp(x); }
  static auto partial(auto, auto exp_x) { return exp_x; }
};
struct Exp2 {
  static auto value(auto x) { return exp2(x); }
  static auto partial(auto, auto exp2_x) { return std::numbers::ln2_v<Base<decltype(exp2_x)>> * exp2_x; }
};
struct Exp10 {
  template <std::floating_point T>
  static T value(T x) {
    return std::pow(T(10), x);
  }
  template <DualNumber T>
  static T value(const T& x) {
    return dual_unary<Exp10>(x);
  }
  static auto partial(auto, auto exp10_x) { return std::numbers::ln10_v<Base<decltype(exp10_x)>> * exp10_x; }
};
struct Expm1 {
  static auto value(auto x) { return expm1(x); }
  static auto partial(auto x, auto) { return exp(x); }  // expm1(x) + 1 would cancel for x ≪ 0
};
struct Log {
  static bool is_kink(auto x) { return x == 0; }
  static auto value(auto x) { return log(x); }
  static auto partial(auto x, auto) { return 1 / x; }
};
struct Log2 {
  static bool is_kink(auto x) { return x == 0; }
  static auto value(auto x) { return log2(x); }
  static auto partial(auto x, auto) { return std::numbers::log2e_v<Base<decltype(x)>> / x; }
};
struct Log10 {
  static bool is_kink(auto x) { return x == 0; }
  static auto value(auto x) { return log10(x); }
  static auto partial(auto x, auto) { return std::numbers::log10e_v<Base<decltype(x)>> / x; }
};
struct Log1p {
  static bool is_kink(auto x) { return x == -1; }
  static auto value(auto x) { return log1p(x); }
  static auto partial(auto x, auto) { return 1 / (1 + x); }
};
struct Sigmoid {
  static auto value(auto x) { return sigmoid(x); }
  template <std::floating_point T>
  static T partial(T x, T) {
    return sigmoid_slope(x);
  }
  template <DualNumber T>
  static T partial(const T& x, const T& sigmoid_x) {
    const auto slope = partial(x.value(), sigmoid_x.value());
    return dual_of<Sigmoid>(x, slope, -slope * tanh(x.value() / 2));
  }
};
struct Softplus {
  static auto value(auto x) { return softplus(x); }
  static auto partial(auto x, auto) { return sigmoid(x); }
};
/// d sigmoid(x − y) / dx.
struct SigmoidSlopeOfDifference {
  template <std::floating_point T>
  static T value(T x, T y) {
    const T slope = sigmoid_slope(x - y);
    return slope - slope * (std::tanh((x - y) / 2) * lost_by_difference(x, y));
  }
  template <DualNumber T>
  static T value(const T& x, const T& y) {
    return dual_binary<SigmoidSlopeOfDifference, T>(x, y);
  }
  static auto partial_x(auto x, auto y, auto slope) { return -slope * tanh((x - y) / 2); }
  static auto partial_y(auto x, auto y, auto slope) { return slope * tanh((x - y) / 2); }
};
struct SigmoidOfDifference {
  template <std::floating_point T>
  static T value(T x, T y) {
    const T s = sigmoid_of(x - y);
    return s + s * (sigmoid_of(y - x) * lost_by_difference(x, y));
  }
  template <DualNumber T>
  static T value(const T& x, const T& y) {
    return dual_binary<SigmoidOfDifference, T>(x, y);
  }
  static auto partial_x(auto x, auto y, auto) { return SigmoidSlopeOfDifference::value(x, y); }
  static auto partial_y(auto x, auto y, auto) { return -SigmoidSlopeOfDifference::value(x, y); }
};
struct LogSumExp {
  static auto value(auto x, auto y) { return logsumexp(x, y); }
  static auto partial_x(auto x, auto y, auto) { return share(x, y); }
  static auto partial_y(auto x, auto y, auto) { return share(y, x); }

 private:
  static auto share(auto x, auto y) {
    return isinf(x) && x == y ? decltype(x)(0.5) : SigmoidOfDifference::value(x, y);
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

/// 10 to the power of x.
template <template <class...> class Formula, class... Parts>
requires Differentiable<Formula<Parts...>>
[[nodiscard]] auto exp10(const Formula<Parts...>& x) { return detail::make_unary<detail::Exp10>(x); }
template <class T, std::size_t N, class Tag>
[[nodiscard]] auto exp10(const Dual<T, N, Tag>& x) {
  return detail::make_unary<detail::Exp10>(x);
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
template <template <class...> class Formula, class... Parts>
requires Differentiable<Formula<Parts...>>
[[nodiscard]] auto sigmoid(const Formula<Parts...>& x) { return detail::make_unary<detail::Sigmoid>(x); }
template <class T, std::size_t N, class Tag>
[[nodiscard]] auto sigmoid(const Dual<T, N, Tag>& x) {
  return detail::make_unary<detail::Sigmoid>(x);
}

/// log(1 + exp(x)).
template <template <class...> class Formula, class... Parts>
requires Differentiable<Formula<Parts...>>
[[nodiscard]] auto softplus(const Formula<Parts...>& x) { return detail::make_unary<detail::Softplus>(x); }
template <class T, std::size_t N, class Tag>
[[nodiscard]] auto softplus(const Dual<T, N, Tag>& x) {
  return detail::make_unary<detail::Softplus>(x);
}

/// log(exp(x) + exp(y)), near its zeros to ε of the arguments. The derivatives are the softmax of (x, y);
/// equal infinities share 1 equally.
template <class... Named, class X, class Y>
requires(sizeof...(Named) == 0 && detail::FormulaOperands<X, Y>)
    [[nodiscard]] auto logsumexp(const X& x, const Y& y, const Named&...) {
  return detail::make_binary<detail::LogSumExp>(x, y);
}

}  // namespace tapestry

#pragma once
#include <numbers>
#include <tapestry/autodiff/detail/functions/scalar_functions.hpp>
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
  static auto value(std::floating_point auto x) { return std::pow(decltype(x)(10), x); }
  static auto value(DualNumber auto x) { return dual_unary<Exp10>(x); }
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
  static auto partial(auto x, auto) { return sigmoid_slope(x); }
  static auto curvature(auto x, auto, auto slope) { return -slope * tanh(x / 2); }
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
  static auto value(DualNumber auto x, auto y) {
    return dual_binary<SigmoidSlopeOfDifference, decltype(x)>(x, y);
  }
  static auto partial_x(auto x, auto y, auto slope) { return -slope * tanh((x - y) / 2); }
  static auto partial_y(auto x, auto y, auto slope) { return slope * tanh((x - y) / 2); }
};
struct SigmoidOfDifference {
  template <std::floating_point T>
  static T value(T x, T y) {
    const T s = sigmoid(x - y);
    return s + s * (sigmoid(y - x) * lost_by_difference(x, y));
  }
  static auto value(DualNumber auto x, auto y) { return dual_binary<SigmoidOfDifference, decltype(x)>(x, y); }
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

[[nodiscard]] auto exp(const detail::Argument auto& x) { return detail::make_unary<detail::Exp>(x); }

/// 2 to the power of x.
[[nodiscard]] auto exp2(const detail::Argument auto& x) { return detail::make_unary<detail::Exp2>(x); }

/// 10 to the power of x.
template <int = 0, detail::Argument X>
[[nodiscard]] auto exp10(const X& x) {
  return detail::make_unary<detail::Exp10>(x);
}

/// exp(x) − 1.
[[nodiscard]] auto expm1(const detail::Argument auto& x) { return detail::make_unary<detail::Expm1>(x); }

/// At 0 the value is −∞ and the derivative +∞; below, the value is NaN.
[[nodiscard]] auto log(const detail::Argument auto& x) { return detail::make_unary<detail::Log>(x); }
[[nodiscard]] auto log2(const detail::Argument auto& x) { return detail::make_unary<detail::Log2>(x); }
[[nodiscard]] auto log10(const detail::Argument auto& x) { return detail::make_unary<detail::Log10>(x); }

/// log(1 + x).
[[nodiscard]] auto log1p(const detail::Argument auto& x) { return detail::make_unary<detail::Log1p>(x); }

/// 1 / (1 + exp(−x)).
template <int = 0, detail::Argument X>
[[nodiscard]] auto sigmoid(const X& x) {
  return detail::make_unary<detail::Sigmoid>(x);
}

/// log(1 + exp(x)).
template <int = 0, detail::Argument X>
[[nodiscard]] auto softplus(const X& x) {
  return detail::make_unary<detail::Softplus>(x);
}

/// log(exp(x) + exp(y)), near its zeros to ε of the arguments. The derivatives are the softmax of (x, y);
/// equal infinities share 1 equally.
template <int = 0, class X, detail::Arguments<X> Y>
[[nodiscard]] auto logsumexp(const X& x, const Y& y) {
  return detail::make_binary<detail::LogSumExp>(x, y, "logsumexp");
}
}  // namespace tapestry

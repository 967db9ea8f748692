#pragma once
#include <tapestry/autodiff/arrays/elementwise.hpp>
#include <tapestry/autodiff/functions.hpp>

namespace tapestry {

// The functions of one scalar, element by element, as formulas; see elementwise.hpp.

template <DifferentiableArray X>
[[nodiscard]] auto operator-(const X& x) {
  return detail::array_unary<detail::Negate>(x);
}

template <DifferentiableArray X>
[[nodiscard]] auto exp(const X& x) {
  return detail::array_unary<detail::Exp>(x);
}

template <DifferentiableArray X>
[[nodiscard]] auto exp2(const X& x) {
  return detail::array_unary<detail::Exp2>(x);
}

template <DifferentiableArray X>
[[nodiscard]] auto expm1(const X& x) {
  return detail::array_unary<detail::Expm1>(x);
}

template <DifferentiableArray X>
[[nodiscard]] auto log(const X& x) {
  return detail::array_unary<detail::Log>(x);
}

template <DifferentiableArray X>
[[nodiscard]] auto log2(const X& x) {
  return detail::array_unary<detail::Log2>(x);
}

template <DifferentiableArray X>
[[nodiscard]] auto log10(const X& x) {
  return detail::array_unary<detail::Log10>(x);
}

template <DifferentiableArray X>
[[nodiscard]] auto log1p(const X& x) {
  return detail::array_unary<detail::Log1p>(x);
}

template <DifferentiableArray X>
[[nodiscard]] auto sigmoid(const X& x) {
  return detail::array_unary<detail::Sigmoid>(x);
}

template <DifferentiableArray X>
[[nodiscard]] auto softplus(const X& x) {
  return detail::array_unary<detail::Softplus>(x);
}

template <DifferentiableArray X>
[[nodiscard]] auto sin(const X& x) {
  return detail::array_unary<detail::Sin>(x);
}

template <DifferentiableArray X>
[[nodiscard]] auto cos(const X& x) {
  return detail::array_unary<detail::Cos>(x);
}

template <DifferentiableArray X>
[[nodiscard]] auto tan(const X& x) {
  return detail::array_unary<detail::Tan>(x);
}

template <DifferentiableArray X>
[[nodiscard]] auto asin(const X& x) {
  return detail::array_unary<detail::Asin>(x);
}

template <DifferentiableArray X>
[[nodiscard]] auto acos(const X& x) {
  return detail::array_unary<detail::Acos>(x);
}

template <DifferentiableArray X>
[[nodiscard]] auto atan(const X& x) {
  return detail::array_unary<detail::Atan>(x);
}

template <DifferentiableArray X>
[[nodiscard]] auto sinh(const X& x) {
  return detail::array_unary<detail::Sinh>(x);
}

template <DifferentiableArray X>
[[nodiscard]] auto cosh(const X& x) {
  return detail::array_unary<detail::Cosh>(x);
}

template <DifferentiableArray X>
[[nodiscard]] auto tanh(const X& x) {
  return detail::array_unary<detail::Tanh>(x);
}

template <DifferentiableArray X>
[[nodiscard]] auto asinh(const X& x) {
  return detail::array_unary<detail::Asinh>(x);
}

template <DifferentiableArray X>
[[nodiscard]] auto acosh(const X& x) {
  return detail::array_unary<detail::Acosh>(x);
}

template <DifferentiableArray X>
[[nodiscard]] auto atanh(const X& x) {
  return detail::array_unary<detail::Atanh>(x);
}

template <DifferentiableArray X>
[[nodiscard]] auto square(const X& x) {
  return detail::array_unary<detail::Square>(x);
}

template <DifferentiableArray X>
[[nodiscard]] auto sqrt(const X& x) {
  return detail::array_unary<detail::Sqrt>(x);
}

template <DifferentiableArray X>
[[nodiscard]] auto cbrt(const X& x) {
  return detail::array_unary<detail::Cbrt>(x);
}

template <DifferentiableArray X>
[[nodiscard]] auto erf(const X& x) {
  return detail::array_unary<detail::Erf>(x);
}

template <DifferentiableArray X>
[[nodiscard]] auto erfc(const X& x) {
  return detail::array_unary<detail::Erfc>(x);
}

template <DifferentiableArray X>
[[nodiscard]] auto lgamma(const X& x) {
  return detail::array_unary<detail::Lgamma>(x);
}

template <DifferentiableArray X>
[[nodiscard]] auto tgamma(const X& x) {
  return detail::array_unary<detail::Tgamma>(x);
}

template <DifferentiableArray X>
[[nodiscard]] auto abs(const X& x) {
  return detail::array_unary<detail::Abs>(x);
}

}  // namespace tapestry

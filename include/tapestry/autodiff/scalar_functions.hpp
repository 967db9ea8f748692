#pragma once
#include <cmath>
#include <concepts>

namespace tapestry {

/// 1 / (1 + exp(−x)), without overflow for any x.
template <std::floating_point T>
[[nodiscard]] T sigmoid(T x) {
  const T e = std::exp(-std::abs(x));
  return (x < 0 ? e : T(1)) / (1 + e);
}

/// d sigmoid / dx = e / (1 + e)², e = exp(−|x|): to full precision where 1 − sigmoid(x) would cancel.
template <std::floating_point T>
[[nodiscard]] T sigmoid_derivative(T x) {
  const T e = std::exp(-std::abs(x));
  return e / ((1 + e) * (1 + e));
}

/// log(1 + exp(x)), without overflow for any x, and without cancellation where it is small.
template <std::floating_point T>
[[nodiscard]] T softplus(T x) {
  return (x > 0 ? x : T(0)) + std::log1p(std::exp(-std::abs(x)));
}

/// log(exp(x) + exp(y)), without overflow; of two equal infinities, that infinity.
template <std::floating_point T>
[[nodiscard]] T logsumexp(T x, T y) {
  if (std::isinf(x) && x == y) return x;
  return (x < y ? y : x) + std::log1p(std::exp(-std::abs(x - y)));
}

/// d tanh / dx, given both x and tanh x: to full precision also where 1 − tanh² would cancel.
template <std::floating_point T>
[[nodiscard]] T tanh_derivative(T x, T tanh_x) {
  if (std::abs(tanh_x) < T(0.5)) return 1 - tanh_x * tanh_x;
  const T e = std::exp(-2 * std::abs(x));
  return 4 * e / ((1 + e) * (1 + e));
}

}  // namespace tapestry

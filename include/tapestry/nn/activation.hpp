#pragma once
#include <cmath>
#include <concepts>
#include <string_view>

namespace tapestry::nn {

/// Functions applied to each value on its own:
///
///   linear x | leaky x or 0.1·x below 0 | relu max(x, 0) | logistic σ(x) = 1/(1 + e^−x)
///   swish x·σ(x) | mish x·tanh(log(1 + e^x))
///
/// At the kink x = 0 leaky has the derivative 0.1 and relu 0, as in Darknet. NaN stays NaN.
enum class Activation { linear, leaky, relu, logistic, swish, mish };

/// Darknet's name of an activation.
[[nodiscard]] constexpr std::string_view name_of(Activation activation) {
  switch (activation) {
    case Activation::linear:
      return "linear";
    case Activation::leaky:
      return "leaky";
    case Activation::relu:
      return "relu";
    case Activation::logistic:
      return "logistic";
    case Activation::swish:
      return "swish";
    case Activation::mish:
      return "mish";
  }
  return "";
}

/// True for the functions that are x above 0 and slope · x elsewhere: linear, leaky and relu.
[[nodiscard]] constexpr bool is_piecewise_linear(Activation activation) {
  return activation == Activation::linear || activation == Activation::leaky ||
         activation == Activation::relu;
}

/// Slope at and below 0 of a piecewise linear activation.
template <std::floating_point T>
[[nodiscard]] constexpr T negative_slope(Activation activation) {
  return activation == Activation::leaky ? T(0.1) : activation == Activation::relu ? T(0) : T(1);
}

/// σ(x), finite for every finite x and without cancellation at either end.
template <std::floating_point T>
[[nodiscard]] T logistic(T x) {
  const T decayed = std::exp(-std::abs(x));
  return (x >= 0 ? T(1) : decayed) / (1 + decayed);
}

/// One value of an activation.
template <std::floating_point T>
[[nodiscard]] T activate(Activation activation, T x) {
  switch (activation) {
    case Activation::logistic:
      return logistic(x);
    case Activation::swish:
      return x * logistic(x);
    // tanh(log(1 + e^x)) = n / (n + 2) with n = e^x (e^x + 2); beyond 20 it is 1 to double precision.
    case Activation::mish: {
      if (x > 20) return x;
      const T e = std::exp(x);
      const T n = e * (e + 2);
      return x * (n / (n + 2));
    }
    default:
      return x > 0 ? x : negative_slope<T>(activation) * x;
  }
}

/// Derivative of an activation at its argument x.
template <std::floating_point T>
[[nodiscard]] T activation_slope(Activation activation, T x) {
  switch (activation) {
    case Activation::logistic: {
      const T s = logistic(x);
      return s * logistic(-x);
    }
    case Activation::swish: {
      const T s = logistic(x);
      return s + x * s * logistic(-x);
    }
    case Activation::mish: {
      if (x > 20) return 1;
      const T e = std::exp(x);
      const T n = e * (e + 2);
      const T t = n / (n + 2);
      // 1 − t² = (4n + 4)/(n + 2)², and d/dx log(1 + e^x) = σ(x)
      return t + x * logistic(x) * (4 * n + 4) / ((n + 2) * (n + 2));
    }
    default:
      return x > 0 || x != x ? (x > 0 ? T(1) : x) : negative_slope<T>(activation);
  }
}

}  // namespace tapestry::nn

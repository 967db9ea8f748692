#pragma once
#include <array>
#include <cmath>
#include <concepts>
#include <string_view>

namespace tapestry::nn {

/// Functions applied to each value on its own:
///
///   linear x | leaky x or 0.1·x below 0 | relu max(x, 0) | logistic σ(x) = 1/(1 + e^−x)
///   swish x·σ(x) | mish x·tanh(log(1 + e^x)) | hard_mish 0 below −2, x²/2 + x up to 0, x above
///   relu6 max(0, min(x, 6)) | elu x or e^x − 1 below 0 | tanh
///
/// At the kink x = 0 leaky has the derivative 0.1 and relu and relu6 0, and so has relu6 at 6, as in Darknet.
/// NaN stays NaN.
enum class Activation { linear, leaky, relu, logistic, swish, mish, hard_mish, relu6, elu, tanh };

inline constexpr std::array<Activation, 10> activations{
    Activation::linear, Activation::leaky,     Activation::relu,  Activation::logistic, Activation::swish,
    Activation::mish,   Activation::hard_mish, Activation::relu6, Activation::elu,      Activation::tanh};

/// The activations by name, for messages.
inline constexpr std::string_view activation_names =
    "linear, leaky, relu, logistic, swish, mish, hard_mish, relu6, elu or tanh";

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
    case Activation::hard_mish:
      return "hard_mish";
    case Activation::relu6:
      return "relu6";
    case Activation::elu:
      return "elu";
    case Activation::tanh:
      return "tanh";
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
    case Activation::hard_mish:
      return x > 0 ? x : x <= -2 ? T(0) : x * x / 2 + x;
    case Activation::relu6:
      return x <= 0 ? T(0) : x >= 6 ? T(6) : x;
    case Activation::elu:
      return x > 0 ? x : std::expm1(x);
    case Activation::tanh:
      return std::tanh(x);
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
    case Activation::hard_mish:
      return x > 0 ? T(1) : x <= -2 ? T(0) : x + 1;
    case Activation::relu6:
      return x <= 0 || x >= 6 ? T(0) : x != x ? x : T(1);
    case Activation::elu:
      return x > 0 ? T(1) : std::exp(x);
    case Activation::tanh: {  // 1 − tanh² = 4·σ(2x)·σ(−2x), which keeps its digits
      return 4 * logistic(2 * x) * logistic(-2 * x);
    }
    default:
      return x > 0 || x != x ? (x > 0 ? T(1) : x) : negative_slope<T>(activation);
  }
}

}  // namespace tapestry::nn

#pragma once
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string_view>

namespace tapestry::nn {
/// Activations other than the leaky ones:
///
///   logistic σ(x) = 1/(1 + e^−x) | swish x·σ(x) | mish x·tanh(log(1 + e^x))
///   hard_logistic min(max(a·x + b, 0), 1) | hard_swish x·hard_logistic(x) | clip min(max(x, a), b)
///
/// At a kink the derivative is the constant side's; NaN stays NaN. The kernels' exponential has a relative
/// error below 2 ε and is cut where it would leave the normal numbers: σ, swish and mish are within 6 ε ·
/// |value| + 3 · max(1, |x|) · (the smallest normal number), and slopes within 8 ε.
enum class CurveKind : std::uint8_t { none, logistic, swish, mish, hard_logistic, hard_swish, clip };

/// A curved activation with its settings.
template <std::floating_point T>
struct Curve {
  CurveKind kind = CurveKind::none;
  T a = 0;
  T b = 0;
};

/// Functions applied to each value on its own:
///
///   linear x | leaky x or 0.1·x below 0 | relu max(x, 0) | logistic σ(x) = 1/(1 + e^−x)
///   swish x·σ(x) | mish x·tanh(log(1 + e^x)) | hard_mish 0 below −2, x²/2 + x up to 0, x above
///   relu6 max(0, min(x, 6)) | elu x or e^x − 1 below 0 | tanh
///
/// At the kink x = 0 leaky has the derivative 0.1, relu and relu6 have 0. relu6 has 0 also at 6, as
/// in Darknet. NaN stays NaN.
enum class Activation { linear, leaky, relu, logistic, swish, mish, hard_mish, relu6, elu, tanh };

inline constexpr std::array<Activation, 10> activations{
    Activation::linear, Activation::leaky,     Activation::relu,  Activation::logistic, Activation::swish,
    Activation::mish,   Activation::hard_mish, Activation::relu6, Activation::elu,      Activation::tanh};

/// The activations by name, for messages.
inline constexpr std::string_view activation_names =
    "linear, leaky, relu, logistic, swish, mish, hard_mish, relu6, elu or tanh";

/// Darknet's name of an activation.
[[nodiscard]] constexpr std::string_view name_of(Activation activation) {
  constexpr std::array<std::string_view, activations.size()> names{
      "linear", "leaky", "relu", "logistic", "swish", "mish", "hard_mish", "relu6", "elu", "tanh"};
  return names[static_cast<std::size_t>(activation)];
}

/// σ(x), finite for every finite x and without cancellation at either end.
template <std::floating_point T>
[[nodiscard]] T logistic(T x) {
  const T decayed = std::exp(-std::abs(x));
  return (x >= 0 ? T(1) : decayed) / (1 + decayed);
}
}  // namespace tapestry::nn

#pragma once
#include <cstddef>
#include <cstdint>

namespace tapestry::nn {

/// Activations that are no leaky ones:
///
///   logistic σ(x) = 1/(1 + e^−x) | swish x·σ(x) | mish x·tanh(log(1 + e^x))
///   hard_logistic min(max(a·x + b, 0), 1) | hard_swish x·hard_logistic(x) | clip min(max(x, a), b)
///
/// At a kink the derivative is that of the side that is constant; NaN stays NaN. The kernels' exponential has
/// a relative error below 2 ε and is cut where it would leave the normal numbers: σ, swish and mish are
/// within 6 ε · |value| + 3 · max(1, |x|) · (the smallest normal number).
enum class CurveKind : std::uint8_t { none, logistic, swish, mish, hard_logistic, hard_swish, clip };

/// A curved activation with its settings.
template <class T>
struct Curve {
  CurveKind kind = CurveKind::none;
  T a = 0;
  T b = 0;
};

}  // namespace tapestry::nn

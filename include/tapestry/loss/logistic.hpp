#pragma once
#include <cmath>
#include <tapestry/nn/activation.hpp>  // logistic

namespace tapestry::loss {

/// dσ/dx = σ(x) · σ(−x), which keeps its digits where σ rounds to 1.
[[nodiscard]] inline double logistic_slope(double x) { return nn::logistic(x) * nn::logistic(-x); }

/// log(1 + eˣ) = −log σ(−x), without overflow.
[[nodiscard]] inline double softplus(double x) {
  return (x > 0 ? x : 0) + std::log1p(std::exp(-std::abs(x)));
}

/// −t · log σ(x) − (1 − t) · log(1 − σ(x)) for a logit x and a wanted probability t in [0, 1].
[[nodiscard]] inline double cross_entropy(double logit, double wanted) {
  return wanted * softplus(-logit) + (1 - wanted) * softplus(logit);
}

/// ∂cross_entropy/∂logit = σ(x) − t, kept accurate as (1 − t) · σ(x) − t · σ(−x).
[[nodiscard]] inline double cross_entropy_slope(double logit, double wanted) {
  return (1 - wanted) * nn::logistic(logit) - wanted * nn::logistic(-logit);
}

}  // namespace tapestry::loss

#pragma once
#include <tapestry/nn/activation.hpp>  // logistic
#include <type_traits>

namespace tapestry::loss {
/// dσ/dx = σ(x) · σ(−x), which keeps its digits where σ rounds to 1.
[[nodiscard]] inline double logistic_slope(double x) { return nn::logistic(x) * nn::logistic(-x); }

/// log(1 + eˣ) = −log σ(−x), without overflow.
[[nodiscard]] inline double softplus(double x) {
  return (x > 0 ? x : 0) + std::log1p(std::exp(-std::abs(x)));
}

/// −t · log σ(x) − (1 − t) · log(1 − σ(x)) = t · softplus(−x) + (1 − t) · softplus(x) for a logit x and a
/// wanted probability t in [0, 1].
template <std::floating_point T>
[[nodiscard]] T binary_cross_entropy(T logit, std::type_identity_t<T> wanted) {
  const T beyond = std::log1p(std::exp(-std::abs(logit)));  // of both softplus
  return wanted * ((logit < 0 ? -logit : 0) + beyond) + (1 - wanted) * ((logit > 0 ? logit : 0) + beyond);
}

/// ∂binary_cross_entropy/∂logit = σ(x) − t, kept accurate as (1 − t) · σ(x) − t · σ(−x).
template <std::floating_point T>
[[nodiscard]] T binary_cross_entropy_slope(T logit, std::type_identity_t<T> wanted) {
  const T decayed = std::exp(-std::abs(logit));  // of both σ, see nn::logistic()
  return (1 - wanted) * ((logit >= 0 ? 1 : decayed) / (1 + decayed)) -
         wanted * ((logit <= 0 ? 1 : decayed) / (1 + decayed));
}
}  // namespace tapestry::loss

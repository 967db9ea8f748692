#pragma once
#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/core/compiled.hpp>

namespace tapestry::loss {
/// Mean binary cross entropy of logits x with wanted probabilities t, each in [0, 1]:
///
///   L = 1/n Σ −t · log σ(x) − (1 − t) · log(1 − σ(x))
///
/// It is computed without overflow, and keeps its digits where σ rounds to 1.
///
/// \param logits  [N, C, H, W], not empty
/// \param wanted  of the same extents
/// \throws ShapeError unless extents are equal and not 0
template <std::floating_point T>
[[nodiscard]] T binary_cross_entropy(const Array<T, 4>& logits, const Array<T, 4>& wanted);

/// Adds value_adjoint · ∂L/∂logits to logits_adjoint: ∂L/∂x = (σ(x) − t)/n.
template <std::floating_point T>
void binary_cross_entropy_adjoint(const Array<T, 4>& logits, const Array<T, 4>& wanted, T value_adjoint,
                                  Array<T, 4>& logits_adjoint);

/// Mean cross entropy of a softmax over axis 1 with wanted shares t of the classes, which sum to 1:
///
///   L = 1/(N·H·W) Σ (log Σ_k exp x_k − Σ_k t_k · x_k)
///
/// \param logits  [N, K, H, W], not empty; of a classifier H and W are 1
/// \param wanted  of the same extents
/// \throws ShapeError unless extents are equal and not 0
template <std::floating_point T>
[[nodiscard]] T cross_entropy(const Array<T, 4>& logits, const Array<T, 4>& wanted);

/// Adds value_adjoint · ∂L/∂logits to logits_adjoint: ∂L/∂x_k = (softmax(x)_k − t_k)/(N·H·W).
template <std::floating_point T>
void cross_entropy_adjoint(const Array<T, 4>& logits, const Array<T, 4>& wanted, T value_adjoint,
                           Array<T, 4>& logits_adjoint);

/// binary_cross_entropy() on the active tape; its pullback is binary_cross_entropy_adjoint().
/// \param wanted  shared, and not to be changed before the tape's last reverse()
template <std::floating_point T>
[[nodiscard]] Variable<T> binary_cross_entropy(const ArrayVariable<T, 4>& logits,
                                               std::shared_ptr<const Array<T, 4>> wanted);

/// cross_entropy() on the active tape; its pullback is cross_entropy_adjoint().
/// \param wanted  as above
template <std::floating_point T>
[[nodiscard]] Variable<T> cross_entropy(const ArrayVariable<T, 4>& logits,
                                        std::shared_ptr<const Array<T, 4>> wanted);

/// The same on a tape of duals.
template <DualNumber D>
[[nodiscard]] Variable<D> binary_cross_entropy(
    const ArrayVariable<D, 4>& logits,
    const std::shared_ptr<const Array<typename D::value_type, 4>>& wanted) {
  const auto tangent = [=](const auto& x, const auto& along) {
    return std::pair(binary_cross_entropy(x, wanted), mean((sigmoid(x) - *wanted) * along));
  };
  return record_tangent(tangent, logits);
}
/// The same on a tape of duals.
template <DualNumber D>
[[nodiscard]] Variable<D> cross_entropy(
    const ArrayVariable<D, 4>& logits,
    const std::shared_ptr<const Array<typename D::value_type, 4>>& wanted) {
  using T = typename D::value_type;
  const auto classes = static_cast<T>(logits.shape()[1]);
  const auto tangent = [=](const auto& x, const auto& along) {
    return std::pair(cross_entropy(x, wanted),
                     Variable<T>(classes * mean((softmax_along(x, 1) - *wanted) * along)));
  };
  return record_tangent(tangent, logits);
}
}  // namespace tapestry::loss

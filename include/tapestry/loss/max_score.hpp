#pragma once
#include <tapestry/loss/responsible.hpp>

namespace tapestry::loss {
namespace detail {

/// 1 − o·p·u as (1 − o) + o·(1 − p) + o·p·(1 − u), which keeps its digits when all three are near 1; of a
/// head without objectness 1 − p·u as (1 − p) + p·(1 − u). Floored at the smallest normal number, so that the
/// loss stays below 709.
template <class T>
[[nodiscard]] double miss(const Predictions<T>& predictions, const Responsible& best, const Target& target);

}  // namespace detail

/// −log(1 − m), m being the largest σ(obj) · p(class) · IoU(box, target) of all candidates of all heads,
/// without σ(obj) for heads that have none; 0 when no box overlaps the target. Its gradient grows as the
/// target is found more surely, where that of a probability fades.
///
/// Kinks: it differentiates the first candidate that attains the maximum; IoU's as in iou_with_gradient().
/// Stays finite for logits of any size. NaN logits give NaN. Source: Zhou et al., RAUCA (ICML 2024), eq. 9,
/// there with complete IoU, which can be negative.
template <class T>
[[nodiscard]] double max_score(const Predictions<T>& predictions, const Target& target);

/// Adds loss_adjoint times the derivative of max_score().
///
/// The derivative to the box is o·p/(1 − m) · ∂IoU; IoU is only known to 2⁻⁵³, so 1 − m is not taken to be
/// less than that there.
template <class T>
void max_score_adjoint(const Predictions<T>& predictions, const Target& target, double loss_adjoint,
                       const LogitsAdjoint<T>& logits_adjoint);

}  // namespace tapestry::loss

#pragma once
#include <concepts>
#include <tapestry/loss/prediction.hpp>  // Target

namespace tapestry::evaluate {

/// How sure a detector is of a target at best: the largest confidence among all candidates whose box has an
/// IoU with the target's of at least `iou_threshold`; 0 if there is none. The confidence is objectness times
/// the probability of the target's class, or of heads without objectness the latter. Candidates count however
/// low it is, and before suppression: one that is_found() finds counts, but one that counts need not survive
/// a surer box that lies elsewhere.
///
/// \param predictions    of the picture, by heads of any decode family
/// \param target         the box in pixels of the network's input
/// \param iou_threshold  0.5 as for P@0.5; met exactly counts
/// \returns  in [0, 1]; candidates do not count whose box, objectness or probability is NaN
/// \throws ShapeError if the logits do not fit the heads; DomainError if there is no such image or class, or
///         as detect::require_layout()
template <std::floating_point T>
[[nodiscard]] double best_confidence(const loss::Predictions<T>& predictions, const loss::Target& target,
                                     double iou_threshold = 0.5);

}  // namespace tapestry::evaluate

#pragma once
#include <cmath>
#include <cstddef>
#include <tapestry/loss/prediction.hpp>
#include <vector>

namespace tapestry::loss {

/// Largest over the classes k of the mean over the matched candidates of (raw logit of k, where k is the
/// target's class, else 0). With two classes or more that is max(0, mean logit of the target's class); with
/// one class the mean itself; with no match 0. The logit is not a probability, and the other classes do
/// not matter: so FCA's published program has it. Its derivative at mean 0 is taken as 0.
template <class T>
[[nodiscard]] double largest_mean_logit(const Predictions<T>& predictions,
                                        const std::vector<Candidate>& matched, std::size_t class_index) {
  if (matched.empty()) return 0;
  const auto& head = predictions.heads[matched.front().head];
  double sum = 0;
  for (const Candidate& candidate : matched)
    sum += logit(predictions, candidate, head.class_channel(class_index));
  const double mean = sum / static_cast<double>(matched.size());
  const bool has_other_classes = head.classes > 1;
  return has_other_classes && mean <= 0 ? 0 : mean;  // NaN stays NaN
}

/// Adds loss_adjoint times the derivative of largest_mean_logit().
template <class T>
void largest_mean_logit_adjoint(const Predictions<T>& predictions, const std::vector<Candidate>& matched,
                                std::size_t class_index, double loss_adjoint,
                                const LogitsAdjoint<T>& logits_adjoint) {
  if (matched.empty()) return;
  const auto& head = predictions.heads[matched.front().head];
  const bool has_other_classes = head.classes > 1;
  if (has_other_classes && largest_mean_logit(predictions, matched, class_index) == 0) return;
  const double slope = loss_adjoint / static_cast<double>(matched.size());
  for (const Candidate& candidate : matched)
    add_to_logit(predictions, candidate, head.class_channel(class_index), slope, logits_adjoint);
}

}  // namespace tapestry::loss

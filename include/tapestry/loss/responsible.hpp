#pragma once
#include <cmath>
#include <cstddef>
#include <optional>
#include <tapestry/loss/prediction.hpp>

namespace tapestry::loss {

/// A candidate together with what it says about the target.
struct Responsible {
  Candidate candidate;
  double objectness = 0;         ///< σ(objectness logit)
  double class_probability = 0;  ///< σ(logit of the target's class)
  Overlap overlap;               ///< of its box with the target

  /// How much the candidate counts as finding the target, in [0, 1].
  [[nodiscard]] double score() const { return objectness * class_probability * overlap.iou; }
};

/// Reads a candidate's three numbers.
template <class T>
[[nodiscard]] Responsible judge(const Predictions<T>& predictions, const Candidate& candidate,
                                const Target& target) {
  return {candidate, nn::logistic(logit(predictions, candidate, objectness_channel)),
          nn::logistic(logit(predictions, candidate, class_channel + target.class_index)),
          iou_with_gradient(decoded_box(predictions, candidate), target.box)};
}

/// The candidate of a head that finds the target best: the largest σ(obj) · p(class) · IoU; none when no
/// box overlaps the target. Ties go to the first candidate, which is also where the losses built on this
/// have their kinks: they differentiate the chosen candidate only. The first score that is NaN wins, so
/// that a NaN among the logits is never overlooked.
template <class T>
[[nodiscard]] std::optional<Responsible> responsible(const Predictions<T>& predictions,
                                                     std::size_t head_index, const Target& target) {
  std::optional<Responsible> best;
  double best_score = 0;
  for_each_candidate(head_index, predictions.heads[head_index], [&](const Candidate& candidate) {
    if (std::isnan(best_score)) return;
    const Responsible found = judge(predictions, candidate, target);
    const double score = found.score();
    if (score > best_score || std::isnan(score)) {
      best = found;
      best_score = score;
    }
  });
  return best;
}

/// The best of all heads' responsible candidates, ties to the first; none when no box overlaps the target.
template <class T>
[[nodiscard]] std::optional<Responsible> responsible(const Predictions<T>& predictions,
                                                     const Target& target) {
  std::optional<Responsible> best;
  for (std::size_t head = 0; head < predictions.heads.size(); ++head) {
    const auto found = responsible(predictions, head, target);
    if (!found || (best && std::isnan(best->score()))) continue;
    if (!best || found->score() > best->score() || std::isnan(found->score())) best = found;
  }
  return best;
}

}  // namespace tapestry::loss

#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <optional>
#include <tapestry/loss/anchor_match.hpp>  // cell_of
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

namespace detail {

/// σ(o)·σ(c) ≤ e^(min(o, 0) + min(c, 0)), so a candidate whose sum lies below this cannot reach `score`. A
/// little lower than exact, so that rounding never decides.
[[nodiscard]] inline double hopeless_sum(double score) { return std::log(score) - 1e-4; }

/// The best score at the cell of the target's centre: a first bound that spares most candidates' boxes.
template <class T>
[[nodiscard]] double score_at_centre(const Predictions<T>& predictions, std::size_t head_index,
                                     const Target& target) {
  const auto& head = predictions.heads[head_index];
  const Cell cell = cell_of(head, target.box, predictions.input_height, predictions.input_width);
  double best = 0;
  for (std::size_t anchor = 0; cell.exists && anchor < head.anchors.size(); ++anchor) {
    const double score = judge(predictions, {head_index, anchor, cell.row, cell.column}, target).score();
    if (score > best) best = score;
  }
  return best;
}

}  // namespace detail

/// The candidate of a head that finds the target best: the largest σ(obj) · p(class) · IoU; none when no
/// score is above `beaten`, which is 0 or more, as when no box overlaps the target. Ties go to the first
/// candidate, which is also where the losses built on this have their kinks: they differentiate the chosen
/// candidate only. The first score that is NaN wins, so that a NaN among the logits is never overlooked.
template <class T>
[[nodiscard]] std::optional<Responsible> responsible(const Predictions<T>& predictions,
                                                     std::size_t head_index, const Target& target,
                                                     double beaten = 0) {
  const auto& head = predictions.heads[head_index];
  const std::size_t cells = head.grid_height * head.grid_width;
  std::optional<Responsible> best;
  double best_score = beaten;
  auto hopeless = static_cast<T>(
      detail::hopeless_sum(std::max(beaten, detail::score_at_centre(predictions, head_index, target))));
  for (std::size_t anchor = 0; anchor < head.anchors.size(); ++anchor) {
    const T* const x =
        predictions.logits[head_index]->data() + logit_index(predictions, {head_index, anchor}, 0);
    const T* const objectness = x + objectness_channel * cells;
    const T* const of_class = x + (class_channel + target.class_index) * cells;
    for (std::size_t cell = 0; cell < cells; ++cell) {
      const T box_sum = x[cell] + x[cell + cells] + x[cell + 2 * cells] + x[cell + 3 * cells];
      const bool cannot_win = std::min(objectness[cell], T(0)) + std::min(of_class[cell], T(0)) < hopeless;
      if (cannot_win && !std::isnan(box_sum + objectness[cell] + of_class[cell])) continue;
      const Candidate candidate{head_index, anchor, cell / head.grid_width, cell % head.grid_width};
      const Responsible found = judge(predictions, candidate, target);
      const double score = found.score();
      if (std::isnan(score)) return found;
      if (!(score > best_score)) continue;
      best = found;
      best_score = score;
      hopeless = std::max(hopeless, static_cast<T>(detail::hopeless_sum(score)));
    }
  }
  return best;
}

/// The best of all heads' responsible candidates, ties to the first; none when no box overlaps the target.
template <class T>
[[nodiscard]] std::optional<Responsible> responsible(const Predictions<T>& predictions,
                                                     const Target& target) {
  std::optional<Responsible> best;
  for (std::size_t head = 0; head < predictions.heads.size(); ++head) {
    const auto found = responsible(predictions, head, target, best ? best->score() : 0);
    if (found) best = found;
    if (best && std::isnan(best->score())) break;
  }
  return best;
}

}  // namespace tapestry::loss

#pragma once
#include <tapestry/loss/detail/box_assignment.hpp>  // cell_of

namespace tapestry::loss {
/// A candidate together with its prediction of the target.
struct Responsible {
  Candidate candidate;
  double objectness = 0;         ///< σ(objectness logit); of a head without objectness class_probability
  double class_probability = 0;  ///< of the target's class, σ(class_logit())
  double confidence = 0;         ///< objectness times class_probability; without objectness the latter alone
  Overlap overlap;               ///< overlap of its box and the target

  /// Score of the candidate as a detection of the target, in [0, 1].
  [[nodiscard]] double score() const { return confidence * overlap.iou; }
};

/// Reads a candidate's three numbers.
template <std::floating_point T>
[[nodiscard]] Responsible examine_candidate(const Predictions<T>& predictions, const Candidate& candidate,
                                            const Target& target) {
  const auto& head = predictions.heads[candidate.head];
  const auto logits = logits_of(predictions, candidate);
  const double of_class = nn::logistic(detect::class_logit(head, target.class_index, logits));
  const auto channel = head.objectness_channel();
  const double objectness = channel ? nn::logistic(logits(*channel)) : of_class;
  const detect::Box box = detect::decode_box(head, detail::place_of(predictions, candidate), logits);
  return {candidate, objectness, of_class, channel ? objectness * of_class : of_class,
          iou_with_gradient(box, target.box)};
}

namespace detail {
/// σ(o)·σ(c) ≤ e^(min(o, 0) + min(c, 0)), so a candidate whose sum lies below this cannot reach `score`.
/// Slightly lower than exact, so that rounding never decides.
[[nodiscard]] inline double least_log_score(double score) { return std::log(score) - 1e-4; }

/// The best score in the cell of the target's centre: a first bound that makes most candidates' boxes
/// unnecessary.
template <std::floating_point T>
[[nodiscard]] double score_at_centre(const Predictions<T>& predictions, std::size_t head_index,
                                     const Target& target) {
  const auto& head = predictions.heads[head_index];
  const GridCell cell = cell_of(head, target.box, predictions.input_height, predictions.input_width);
  double best = 0;
  for (std::size_t anchor = 0; cell.exists && anchor < head.anchor_count(); ++anchor) {
    const double score =
        examine_candidate(predictions, {head_index, anchor, cell.row, cell.column}, target).score();
    if (score > best) best = score;
  }
  return best;
}

/// The logits that bound the cells of one anchor's scores, in a head with four box channels and objectness.
template <std::floating_point T>
struct CellsWithObjectness {
  const T *box, *objectness, *of_class;  ///< of the first cell
  std::size_t count;                     ///< of cells

  /// An upper bound of the log of a cell's confidence.
  [[nodiscard]] T bound(std::size_t cell) const {
    return std::min(objectness[cell], T(0)) + std::min(of_class[cell], T(0));
  }
  /// NaN if a logit of the cell is.
  [[nodiscard]] T sum(std::size_t cell) const {
    const T* const x = box + cell;
    return x[0] + x[count] + x[2 * count] + x[3 * count] + objectness[cell] + of_class[cell];
  }
};

/// The same for a head where one logit bounds them: the class's, without objectness, or the objectness, with
/// exclusive classes, a logit of which alone bounds nothing.
template <std::floating_point T>
struct CellsOfOneBound {
  const T *box, *bounding;
  std::size_t count, channels;  ///< from the box on, that make the score beside the logit that bounds it

  [[nodiscard]] T bound(std::size_t cell) const { return std::min(bounding[cell], T(0)); }
  [[nodiscard]] T sum(std::size_t cell) const {
    T total = bounding[cell];
    for (std::size_t channel = 0; channel < channels; ++channel) total += box[channel * count + cell];
    return total;
  }
};

/// The best of the candidates examined so far.
template <std::floating_point T>
struct BestSoFar {
  std::optional<Responsible> found;
  double score = 0;  ///< the next one must exceed it; NaN ends the search
  T hopeless = 0;    ///< a bound() below it cannot
};

/// Looks through the cells of one anchor.
template <std::floating_point T, class Cells>
void search_cells(const Predictions<T>& predictions, Candidate candidate, const Target& target,
                  const Cells& cells, BestSoFar<T>& best) {
  const std::size_t width = predictions.heads[candidate.head].grid_width;
  T hopeless = best.hopeless;
  for (std::size_t cell = 0; cell < cells.count; ++cell) {
    if (cells.bound(cell) < hopeless && !std::isnan(cells.sum(cell))) continue;
    candidate.row = cell / width;
    candidate.column = cell % width;
    const Responsible found = examine_candidate(predictions, candidate, target);
    const double score = found.score();
    if (score <= best.score) continue;
    best.found = found;
    best.score = score;
    if (std::isnan(score)) return;
    hopeless = best.hopeless = std::max(hopeless, static_cast<T>(least_log_score(score)));
  }
}
}  // namespace detail

/// The candidate of a head that finds the target best: the largest σ(obj) · p(class) · IoU, or p(class) · IoU
/// for a head without objectness. None if no score is above `beaten`, which is at least 0; so none if no box
/// overlaps the target. Ties go to the first candidate; the losses built on this have their kinks there,
/// since they differentiate the chosen candidate only. The first score that is NaN wins, so that a NaN among
/// the logits is never overlooked.
template <std::floating_point T>
[[nodiscard]] std::optional<Responsible> responsible(const Predictions<T>& predictions,
                                                     std::size_t head_index, const Target& target,
                                                     double beaten = 0) {
  const auto& head = predictions.heads[head_index];
  const std::size_t cells = head.grid_height * head.grid_width;
  const double first_bound = std::max(beaten, detail::score_at_centre(predictions, head_index, target));
  detail::BestSoFar<T> best{{}, beaten, static_cast<T>(detail::least_log_score(first_bound))};
  for (std::size_t anchor = 0; anchor < head.anchor_count() && !std::isnan(best.score); ++anchor) {
    const Candidate candidate{head_index, anchor};
    const T* const first = predictions.logits[head_index]->data() + logit_index(predictions, candidate, 0);
    const T* const box = first + head.box_channel() * cells;
    const T* const of_class = first + head.class_channel(target.class_index) * cells;
    const auto objectness = head.objectness_channel();
    if (objectness && head.exclusive_classes)
      detail::search_cells(
          predictions, candidate, target,
          detail::CellsOfOneBound<T>{box, first + *objectness * cells, cells, head.candidate_channel_count()},
          best);
    else if (objectness)
      detail::search_cells(predictions, candidate, target,
                           detail::CellsWithObjectness<T>{box, first + *objectness * cells, of_class, cells},
                           best);
    else
      detail::search_cells(predictions, candidate, target,
                           detail::CellsOfOneBound<T>{box, of_class, cells, head.box_channel_count()}, best);
  }
  return best.found;
}

/// The best of all heads' responsible candidates, ties to the first; none when no box overlaps the target.
template <std::floating_point T>
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

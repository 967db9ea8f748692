#pragma once
#include <concepts>
#include <cstddef>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/detect/box_formula.hpp>
#include <tapestry/detect/box_overlap.hpp>
#include <tapestry/detect/class_score.hpp>
#include <tapestry/detect/head.hpp>
#include <tapestry/loss/prediction.hpp>  // Target
#include <vector>

namespace tapestry::evaluate {

namespace detail {

template <std::floating_point T>
void require_logits(const loss::Predictions<T>& predictions) {
  const auto& [heads, logits, image, height, width] = predictions;
  if (logits.size() != heads.size())
    throw ShapeError("best_confidence: logits of " + std::to_string(logits.size()) + " heads, expected " +
                     std::to_string(heads.size()));
  for (std::size_t h = 0; h < heads.size(); ++h) {
    detect::require_layout("best_confidence", heads[h]);
    require_shape("best_confidence", "logits", *logits[h],
                  {logits[h]->shape(0), heads[h].channel_count(), heads[h].grid_height, heads[h].grid_width});
    if (image >= logits[h]->shape(0))
      throw DomainError("best_confidence: image " + std::to_string(image) + " of a batch of " +
                        std::to_string(logits[h]->shape(0)));
  }
}

}  // namespace detail

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
                                     double iou_threshold = 0.5) {
  detect::require_class("best_confidence", predictions.heads, target.class_index);
  detail::require_logits(predictions);
  const auto height = static_cast<double>(predictions.input_height);
  const auto width = static_cast<double>(predictions.input_width);
  double best = 0;
  for (std::size_t h = 0; h < predictions.heads.size(); ++h) {
    const detect::Head& head = predictions.heads[h];
    const auto objectness_channel = head.objectness_channel();
    const std::size_t cells = head.grid_height * head.grid_width;
    const T* of_image = predictions.logits[h]->data() + predictions.image * head.channel_count() * cells;
    for (std::size_t candidate = 0; candidate < head.candidate_count(); ++candidate) {
      const std::size_t anchor = candidate / cells, cell = candidate % cells;
      const T* first = of_image + anchor * head.candidate_channel_count() * cells + cell;
      const auto logit = [&](std::size_t channel) { return static_cast<double>(first[channel * cells]); };
      const double objectness =
          objectness_channel ? detect::probability(head, logit(*objectness_channel)) : 1.0;
      if (!(objectness > best)) continue;  // the other factor is at most 1
      const double confidence = objectness * detect::ClassScores(head, logit)(target.class_index);
      if (!(confidence > best)) continue;
      const detect::CandidatePlace place{anchor, cell / head.grid_width, cell % head.grid_width, width,
                                         height};
      if (detect::iou(detect::decode_box(head, place, logit), target.box) >= iou_threshold) best = confidence;
    }
  }
  return best;
}

}  // namespace tapestry::evaluate

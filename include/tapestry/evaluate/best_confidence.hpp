#pragma once
#include <concepts>
#include <cstddef>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/detect/box_decode.hpp>
#include <tapestry/detect/box_overlap.hpp>
#include <tapestry/detect/head.hpp>
#include <tapestry/loss/prediction.hpp>  // Target
#include <vector>

namespace tapestry::evaluate {

/// How sure a detector is of a target at best: the largest confidence, objectness times the probability of
/// the target's class, among all candidates whose box has an IoU with the target's of at least
/// `iou_threshold`; 0 if there is none. Candidates count however low their confidence, and before
/// suppression: one that is_found() finds counts, but one that counts need not survive a surer box that lies
/// elsewhere.
///
/// \param predictions    of the picture, by heads of any decode family
/// \param target         the box in pixels of the network's input
/// \param iou_threshold  0.5 as for P@0.5; met exactly counts
/// \returns  in [0, 1]; candidates with a NaN among their logits do not count
/// \throws ShapeError if the logits do not fit the heads; DomainError if there is no such image or class
template <std::floating_point T>
[[nodiscard]] double best_confidence(const loss::Predictions<T>& predictions, const loss::Target& target,
                                     double iou_threshold = 0.5) {
  const auto& [heads, logits, image, input_height, input_width] = predictions;
  detect::require_class("best_confidence", heads, target.class_index);
  if (logits.size() != heads.size())
    throw ShapeError("best_confidence: logits of " + std::to_string(logits.size()) + " heads, expected " +
                     std::to_string(heads.size()));
  double best = 0;
  for (std::size_t h = 0; h < heads.size(); ++h) {
    const detect::Head& head = heads[h];
    const std::size_t cells = head.grid_height * head.grid_width;
    require_shape("best_confidence", "logits", *logits[h],
                  {logits[h]->shape(0), head.channel_count(), head.grid_height, head.grid_width});
    if (image >= logits[h]->shape(0))
      throw DomainError("best_confidence: image " + std::to_string(image) + " of a batch of " +
                        std::to_string(logits[h]->shape(0)));
    const T* of_image = logits[h]->data() + image * head.channel_count() * cells;
    for (std::size_t candidate = 0; candidate < head.candidate_count(); ++candidate) {
      const std::size_t anchor = candidate / cells, cell = candidate % cells;
      const T* first = of_image + anchor * (5 + head.classes) * cells + cell;
      const auto logit = [&](std::size_t channel) { return static_cast<double>(first[channel * cells]); };
      const double objectness = detect::probability(head, logit(4));
      if (!(objectness > best)) continue;  // the class factor is at most 1
      const double confidence = objectness * detect::probability(head, logit(5 + target.class_index));
      if (!(confidence > best)) continue;
      const detect::Box box =
          detect::decode_box(head, anchor, cell / head.grid_width, cell % head.grid_width,
                             {logit(0), logit(1), logit(2), logit(3)}, static_cast<double>(input_width),
                             static_cast<double>(input_height));
      if (detect::iou(box, target.box) >= iou_threshold) best = confidence;
    }
  }
  return best;
}

}  // namespace tapestry::evaluate

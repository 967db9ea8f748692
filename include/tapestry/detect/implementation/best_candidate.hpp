#pragma once
#include <concepts>
#include <cstddef>
#include <optional>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/detect/best_candidate.hpp>
#include <tapestry/detect/box_formula.hpp>
#include <tapestry/detect/box_overlap.hpp>
#include <tapestry/detect/class_score.hpp>
#include <tapestry/detect/head.hpp>
#include <vector>

namespace tapestry::detect {

template <std::floating_point T>
std::optional<BestCandidate> best_candidate(const std::vector<Head>& heads,
                                            const std::vector<const Array<T, 4>*>& logits, std::size_t image,
                                            const CandidateSearch& search, std::size_t height,
                                            std::size_t width) {
  require_class("best_candidate", heads, search.class_index);
  if (logits.size() != heads.size())
    throw ShapeError("best_candidate: logits of " + std::to_string(logits.size()) + " heads, expected " +
                     std::to_string(heads.size()));
  std::optional<BestCandidate> best;
  for (std::size_t h = 0; h < heads.size(); ++h) {
    const Head& head = heads[h];
    require_layout("best_candidate", head);
    require_shape("best_candidate", "logits", *logits[h],
                  {logits[h]->shape(0), head.channel_count(), head.grid_height, head.grid_width});
    if (image >= logits[h]->shape(0))
      throw DomainError("best_candidate: image " + std::to_string(image) + " of a batch of " +
                        std::to_string(logits[h]->shape(0)));
    const auto objectness_channel = head.objectness_channel();
    const std::size_t cells = head.grid_height * head.grid_width;
    const T* const of_image = logits[h]->data() + image * head.channel_count() * cells;
    for (std::size_t candidate = 0; candidate < head.candidate_count(); ++candidate) {
      const std::size_t anchor = candidate / cells, cell = candidate % cells;
      const T* const first = of_image + anchor * head.candidate_channel_count() * cells + cell;
      const auto logit = [&](std::size_t channel) { return static_cast<double>(first[channel * cells]); };
      const double least = best ? best->confidence : 0;
      const double objectness = objectness_channel ? probability(head, logit(*objectness_channel)) : 1.0;
      if (!(objectness > least)) continue;  // the other factor is at most 1
      const double confidence = objectness * ClassScores(head, logit)(search.class_index);
      if (!(confidence > least)) continue;
      const CandidatePlace place{anchor, cell / head.grid_width, cell % head.grid_width,
                                 static_cast<double>(width), static_cast<double>(height)};
      if (!search.target || iou(decode_box(head, place, logit), *search.target) >= search.iou_threshold)
        best = {h, candidate, confidence};
    }
  }
  return best;
}

template decltype(best_candidate<float>) best_candidate<float>;
template decltype(best_candidate<double>) best_candidate<double>;

}  // namespace tapestry::detect

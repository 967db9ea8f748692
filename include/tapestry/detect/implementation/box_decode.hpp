#pragma once
#include <cmath>
#include <concepts>
#include <cstddef>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/detect/box_decode.hpp>
#include <tapestry/detect/box_formula.hpp>
#include <tapestry/detect/box_overlap.hpp>
#include <tapestry/detect/class_score.hpp>
#include <tapestry/detect/head.hpp>
#include <vector>

namespace tapestry::detect::detail {

/// Adds the detections of a candidate that is sure enough.
/// \param logit      takes a channel of the candidate
/// \param detection  what they all have: objectness, head and candidate
template <std::invocable<std::size_t> Logits>
void add_detections(const Head& head, const CandidatePlace& place, Logits logit, double confidence_threshold,
                    Detection detection, std::vector<Detection>& detections) {
  const double factor = head.has_objectness() ? detection.objectness : 1;
  const ClassScores scores(head, logit);
  bool has_box = false;  // most candidates have no class that asks for it
  for (std::size_t k = 0; k < head.classes; ++k) {
    detection.confidence = factor * scores(k);
    if (!(detection.confidence > confidence_threshold)) continue;
    if (!has_box) detection.box = decode_box(head, place, logit);
    has_box = true;
    const Box& box = detection.box;
    if (!std::isfinite(box.cx + box.cy + box.w + box.h)) return;
    detection.class_index = k;
    detections.push_back(detection);
  }
}

}  // namespace tapestry::detect::detail

namespace tapestry::detect {

template <std::floating_point T>
std::vector<Detection> decode(const std::vector<Head>& heads, const std::vector<Array<T, 4>>& logits,
                              std::size_t image, double confidence_threshold, std::size_t input_height,
                              std::size_t input_width) {
  if (logits.size() != heads.size())
    throw ShapeError("decode: number of logit arrays differs from that of heads");
  std::vector<Detection> detections;
  for (std::size_t h = 0; h < heads.size(); ++h) {
    const Head& head = heads[h];
    require_layout("decode", head);
    const std::size_t cells = head.grid_height * head.grid_width;
    if (image >= logits[h].shape(0)) throw DomainError("decode: no image " + std::to_string(image));
    require_shape("decode", "logits", logits[h],
                  {logits[h].shape(0), head.channel_count(), head.grid_height, head.grid_width});
    const T* of_image = logits[h].data() + image * head.channel_count() * cells;
    const std::size_t depth = head.candidate_channel_count();
    for (std::size_t candidate = 0; candidate < head.candidate_count(); ++candidate) {
      const std::size_t anchor = candidate / cells, cell = candidate % cells;
      const T* first = of_image + anchor * depth * cells + cell;
      const auto logit = [&](std::size_t channel) { return static_cast<double>(first[channel * cells]); };
      const double objectness = probability(head, logit(surest_channel(head, logit)));
      if (!(objectness > confidence_threshold)) continue;  // no class is surer
      const CandidatePlace place{anchor, cell / head.grid_width, cell % head.grid_width,
                                 static_cast<double>(input_width), static_cast<double>(input_height)};
      detail::add_detections(head, place, logit, confidence_threshold, {0, 0, objectness, {}, h, candidate},
                             detections);
    }
  }
  return detections;
}

template std::vector<Detection> decode<float>(const std::vector<Head>& heads,
                                              const std::vector<Array<float, 4>>& logits, std::size_t image,
                                              double confidence_threshold, std::size_t input_height,
                                              std::size_t input_width);
template std::vector<Detection> decode<double>(const std::vector<Head>& heads,
                                               const std::vector<Array<double, 4>>& logits, std::size_t image,
                                               double confidence_threshold, std::size_t input_height,
                                               std::size_t input_width);

}  // namespace tapestry::detect

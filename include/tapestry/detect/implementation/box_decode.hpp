#pragma once
#include <tapestry/detect/box_decode.hpp>
#include <tapestry/detect/box_decode_variable.hpp>
#include <tapestry/detect/class_score.hpp>
#include <tapestry/detect/detail/box_grid.hpp>

namespace tapestry::detect {
namespace detail {
/// Adds the detections of a candidate that is sure enough.
/// \param logit      takes a channel of the candidate
/// \param detection  common part: objectness, head and candidate
template <std::invocable<std::size_t> Logits>
void add_detections(const Head& head, const CandidatePlace& place, Logits logit, double confidence_threshold,
                    Detection detection, std::vector<Detection>& detections) {
  const double factor = head.has_objectness() ? detection.objectness : 1;
  const ClassScores scores(head, logit);
  bool has_box = false;  // most candidates have no class above the threshold
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

/// Calls visit(image, candidate, place, first) for every candidate of a batch; its channel c lies at
/// first + c · H · W of the logits.
template <class Visit>
void for_each_decoded(const Head& head, std::size_t images, double input_height, double input_width,
                      Visit visit) {
  const std::size_t cells = head.grid_height * head.grid_width;
  for (std::size_t n = 0; n < images; ++n)
    for (std::size_t candidate = 0; candidate < head.candidate_count(); ++candidate) {
      const std::size_t anchor = candidate / cells, cell = candidate % cells;
      const CandidatePlace place{anchor, cell / head.grid_width, cell % head.grid_width, input_width,
                                 input_height};
      const std::size_t before = n * head.channel_count() + anchor * head.candidate_channel_count();
      visit(n, candidate, place, before * cells + cell);
    }
}

template <std::floating_point T>
[[nodiscard]] std::vector<Array<T, 3>> decoded_arrays(const Head& head, const Array<T, 4>& logits,
                                                      double input_height, double input_width) {
  const std::size_t images = logits.shape(0), count = head.candidate_count();
  const std::size_t cells = head.grid_height * head.grid_width;
  std::vector<Array<T, 3>> arrays{Array<T, 3>(Extents<3>{images, count, 4}),
                                  Array<T, 3>(Extents<3>{images, count, 1}),
                                  Array<T, 3>(Extents<3>{images, count, head.classes})};
  const auto decode_one = [&](std::size_t n, std::size_t candidate, const CandidatePlace& place,
                              std::size_t first) {
    const auto logit = [&](std::size_t channel) {
      return static_cast<double>(logits.data()[first + channel * cells]);
    };
    const Box box = decode_box(head, place, logit);
    const std::array<double, 4> values{box.cx, box.cy, box.w, box.h};
    for (std::size_t i = 0; i < 4; ++i) arrays[0](n, candidate, i) = static_cast<T>(values[i]);
    arrays[1](n, candidate, 0) = static_cast<T>(probability(head, logit(surest_channel(head, logit))));
    const ClassScores scores(head, logit);
    for (std::size_t k = 0; k < head.classes; ++k) arrays[2](n, candidate, k) = static_cast<T>(scores(k));
  };
  for_each_decoded(head, images, input_height, input_width, decode_one);
  return arrays;
}

/// Adds the pullback of decoded_arrays(); null for arrays that nothing depends on.
template <std::floating_point T>
void decoded_arrays_adjoint(const Head& head, const Array<T, 4>& logits, double input_height,
                            double input_width, const std::vector<const Array<T, 3>*>& adjoints,
                            Array<T, 4>& logits_adjoint) {
  const std::size_t cells = head.grid_height * head.grid_width;
  const auto add_one = [&](std::size_t n, std::size_t candidate, const CandidatePlace& place,
                           std::size_t first) {
    const auto logit = [&](std::size_t channel) {
      return static_cast<double>(logits.data()[first + channel * cells]);
    };
    const auto add = [&](std::size_t channel, double adjoint) {
      logits_adjoint.data()[first + channel * cells] += static_cast<T>(adjoint);
    };
    const auto add_score = [&](std::size_t channel, T adjoint) {
      if (adjoint != T(0))
        add(channel, static_cast<double>(adjoint) * probability_slope(head, logit(channel)));
    };
    if (adjoints[0] != nullptr) {
      const auto of_box = [&](std::size_t i) { return static_cast<double>((*adjoints[0])(n, candidate, i)); };
      decode_box_adjoint(head, place, logit, {of_box(0), of_box(1), of_box(2), of_box(3)}, add);
    }
    if (adjoints[1] != nullptr) add_score(surest_channel(head, logit), (*adjoints[1])(n, candidate, 0));
    if (adjoints[2] == nullptr) return;
    ClassScores(head, logit)
        .adjoint([&](std::size_t k) { return static_cast<double>((*adjoints[2])(n, candidate, k)); }, add);
  };
  for_each_decoded(head, logits.shape(0), input_height, input_width, add_one);
}

/// Greedy suppression among detections that all suppress each other, most confident first.
inline void suppress_within(std::span<const Detection> detections, double iou_threshold,
                            const SuppressionMeasure& measure, std::vector<Detection>& kept) {
  std::vector<Box> boxes;
  boxes.reserve(detections.size());
  for (const Detection& detection : detections) boxes.push_back(detection.box);
  BoxGrid kept_boxes(boxes);
  for (const Detection& candidate : detections) {
    const auto suppresses = [&](const Box& better) { return measure(better, candidate.box) > iou_threshold; };
    if (kept_boxes.any_overlapping(candidate.box, suppresses)) continue;
    kept.push_back(candidate);
    kept_boxes.insert(candidate.box);
  }
}
}  // namespace detail

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
    if (image >= logits[h].shape(0)) throw DomainError({"decode: no image ", image});
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

template <std::floating_point T>
ArrayVariable<T, 3> confidences(const DecodedHead<T>& head) {
  if (!head.has_objectness) return head.classes;
  return broadcast(head.objectness, head.classes.shape()) * head.classes;
}

template <std::floating_point T>
DecodedHead<T> decode(const Head& head, const ArrayVariable<T, 4>& logits, std::size_t input_height,
                      std::size_t input_width) {
  require_layout("decode", head);
  require_shape("decode", "logits", logits.value(),
                {logits.shape()[0], head.channel_count(), head.grid_height, head.grid_width});
  const auto height = static_cast<double>(input_height), width = static_cast<double>(input_width);
  const auto pullback = [head, values = logits.shared_value(), height, width](
                            const std::vector<const Array<T, 3>*>& adjoints, Array<T, 4>* logits_adjoint) {
    detail::decoded_arrays_adjoint(head, *values, height, width, adjoints, *logits_adjoint);
  };
  auto results =
      record_arrays<T, 3>(detail::decoded_arrays(head, logits.value(), height, width), pullback, logits);
  return {results[0], results[1], results[2], head.has_objectness()};
}

template <std::floating_point T>
std::vector<DecodedHead<T>> detail::decoded_heads(const std::vector<Head>& heads,
                                                  const std::vector<ArrayVariable<T, 4>>& logits,
                                                  std::size_t input_height, std::size_t input_width) {
  if (logits.size() != heads.size())
    throw ShapeError({"decode: logits of ", logits.size(), " heads, expected ", heads.size()});
  std::vector<DecodedHead<T>> decoded;
  for (std::size_t h = 0; h < logits.size(); ++h)
    decoded.push_back(decode(heads[h], logits[h], input_height, input_width));
  return decoded;
}
}  // namespace tapestry::detect

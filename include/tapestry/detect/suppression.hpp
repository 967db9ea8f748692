#pragma once
#include <algorithm>
#include <cstddef>
#include <span>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/detect/box_decode.hpp>
#include <tapestry/detect/box_grid.hpp>
#include <tapestry/detect/suppression_measure.hpp>
#include <tuple>
#include <vector>

namespace tapestry::detect {
namespace detail {

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

/// Greedy non-maximum suppression: going down in confidence, a detection is dropped if its IoU with one
/// kept before, or another measure, is above the threshold. Equal confidences go by head, candidate, then
/// class.
///
/// A detection is compared only with those kept of its class that it overlaps, so that the time grows with
/// the number of detections and not with its square.
///
/// \param iou_threshold  in [0, 1]
/// \param per_class      only detections of the same class suppress each other
/// \param measure        such as Detector::suppression_measure()
/// \returns              the detections kept, most confident first
/// \throws DomainError if the threshold is not in [0, 1], or the measure's exponent not above 0
[[nodiscard]] inline std::vector<Detection> suppress(std::vector<Detection> detections, double iou_threshold,
                                                     bool per_class = true,
                                                     const SuppressionMeasure& measure = {}) {
  if (!(iou_threshold >= 0 && iou_threshold <= 1))
    throw DomainError("suppress: iou_threshold is " + std::to_string(iou_threshold) + ", not in [0, 1]");
  if (const auto exponent = measure.distance_exponent; exponent && !(*exponent > 0))
    throw DomainError("suppress: distance_exponent is " + std::to_string(*exponent) + ", expected above 0");
  const auto is_stronger = [](const Detection& a, const Detection& b) {
    return std::tuple(-a.confidence, a.head, a.candidate, a.class_index) <
           std::tuple(-b.confidence, b.head, b.candidate, b.class_index);
  };
  std::sort(detections.begin(), detections.end(), [&](const Detection& a, const Detection& b) {
    if (per_class && a.class_index != b.class_index) return a.class_index < b.class_index;
    return is_stronger(a, b);
  });
  std::vector<Detection> kept;
  for (auto first = detections.begin(); first != detections.end();) {
    const auto last =
        !per_class ? detections.end() : std::find_if(first, detections.end(), [&](const Detection& other) {
          return other.class_index != first->class_index;
        });
    detail::suppress_within({first, last}, iou_threshold, measure, kept);
    first = last;
  }
  std::sort(kept.begin(), kept.end(), is_stronger);
  return kept;
}

}  // namespace tapestry::detect

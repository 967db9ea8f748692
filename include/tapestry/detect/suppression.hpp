#pragma once
#include <algorithm>
#include <cstddef>
#include <tapestry/detect/box_decode.hpp>
#include <tuple>
#include <vector>

namespace tapestry::detect {

/// Greedy non-maximum suppression: going down in confidence, a detection is dropped if its IoU with one
/// kept before is above the threshold. Equal confidences go by head, candidate, then class.
///
/// \param per_class  only detections of the same class suppress each other
/// \returns          the detections kept, most confident first
[[nodiscard]] inline std::vector<Detection> suppress(std::vector<Detection> detections, double iou_threshold,
                                                     bool per_class = true) {
  std::sort(detections.begin(), detections.end(), [](const Detection& a, const Detection& b) {
    return std::tuple(-a.confidence, a.head, a.candidate, a.class_index) <
           std::tuple(-b.confidence, b.head, b.candidate, b.class_index);
  });
  std::vector<Detection> kept;
  for (const Detection& candidate : detections) {
    const bool is_suppressed = std::any_of(kept.begin(), kept.end(), [&](const Detection& better) {
      return (!per_class || better.class_index == candidate.class_index) &&
             iou(better.box, candidate.box) > iou_threshold;
    });
    if (!is_suppressed) kept.push_back(candidate);
  }
  return kept;
}

}  // namespace tapestry::detect

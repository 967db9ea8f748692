#pragma once
#include <tapestry/detect/detail/box_grid.hpp>
#include <tapestry/detect/suppression.hpp>

namespace tapestry::detect {
std::vector<Detection> suppress(std::vector<Detection> detections, double iou_threshold, bool per_class,
                                const SuppressionMeasure& measure) {
  if (!(iou_threshold >= 0 && iou_threshold <= 1))
    throw DomainError({"suppress: iou_threshold is ", iou_threshold, ", not in [0, 1]"});
  if (const auto exponent = measure.distance_exponent; exponent && !(*exponent > 0))
    throw DomainError({"suppress: distance_exponent is ", *exponent, ", expected above 0"});
  const auto is_stronger = [](const Detection& a, const Detection& b) {
    return std::tuple(-a.confidence, a.head, a.candidate, a.class_index) <
           std::tuple(-b.confidence, b.head, b.candidate, b.class_index);
  };
  std::sort(detections.begin(), detections.end(), [&](const Detection& a, const Detection& b) {
    return per_class && a.class_index != b.class_index ? a.class_index < b.class_index : is_stronger(a, b);
  });
  std::vector<Detection> kept;
  for (auto first = detections.begin(); first != detections.end();) {
    const auto last =
        !per_class ? detections.end() : std::find_if(first, detections.end(), [&](const Detection& other) {
          return other.class_index != first->class_index;
        });
    detail::suppress_within({&*first, static_cast<std::size_t>(last - first)}, iou_threshold, measure, kept);
    first = last;
  }
  std::sort(kept.begin(), kept.end(), is_stronger);
  return kept;
}
}  // namespace tapestry::detect

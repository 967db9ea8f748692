#pragma once
#include <tapestry/detect/box_decode.hpp>

namespace tapestry::detect {
/// Similarity of two detections, at most 1, which suppress() compares with its threshold. It is their IoU, or
/// with an exponent β
///
///   IoU − (d² / c²)^β
///
/// where d is the distance of their centres and c the diagonal of the smallest box around both. β
/// keeps two objects more often if one hides a part of the other. Source: Zheng et al.,
/// "Distance-IoU loss" (AAAI 2020), section 3.3, there with β = 1; β is beta_nms of AlexeyAB's
/// Darknet for nms_kind=diounms, which measures in shares of the picture's extents. Here it is in
/// pixels of the network's input.
struct SuppressionMeasure {
  std::optional<double> distance_exponent{};  ///< β, above 0; none: the IoU alone

  /// At most the IoU, and 0 where the IoU is 0.
  [[nodiscard]] double operator()(const Box& a, const Box& b) const {
    const double overlap = iou(a, b);
    if (!distance_exponent || overlap == 0) return overlap;
    const double distance = std::hypot(a.cx - b.cx, a.cy - b.cy);
    const double diagonal = std::hypot(std::max(a.right(), b.right()) - std::min(a.left(), b.left()),
                                       std::max(a.bottom(), b.bottom()) - std::min(a.top(), b.top()));
    return overlap - std::pow(distance / diagonal, 2 * *distance_exponent);
  }
  bool operator==(const SuppressionMeasure&) const = default;
};

/// Greedy non-maximum suppression: going down in confidence, a detection is dropped if its IoU with one kept
/// before, or another measure, is above the threshold. Equal confidences go by head, candidate, then class.
///
/// A detection is compared only with those kept of its class that it overlaps, so that the time grows with
/// the number of detections and not with its square.
///
/// \param iou_threshold  in [0, 1]
/// \param per_class      only detections of the same class suppress each other
/// \param measure        such as Detector::suppression_measure()
/// \returns              the detections kept, most confident first
/// \throws DomainError if the threshold is not in [0, 1], or the measure's exponent not above 0
[[nodiscard]] std::vector<Detection> suppress(std::vector<Detection> detections, double iou_threshold,
                                              bool per_class = true, const SuppressionMeasure& measure = {});
}  // namespace tapestry::detect

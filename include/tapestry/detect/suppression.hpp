#pragma once
#include <tapestry/core/error.hpp>
#include <tapestry/detect/box_decode.hpp>
#include <tapestry/detect/suppression_measure.hpp>
#include <vector>

namespace tapestry::detect {

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
[[nodiscard]] std::vector<Detection> suppress(std::vector<Detection> detections, double iou_threshold,
                                              bool per_class = true, const SuppressionMeasure& measure = {});

}  // namespace tapestry::detect

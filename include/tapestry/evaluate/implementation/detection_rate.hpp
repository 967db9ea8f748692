#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/detect/box_decode.hpp>
#include <tapestry/detect/box_overlap.hpp>
#include <tapestry/evaluate/detection_rate.hpp>
#include <tapestry/loss/prediction.hpp>
#include <vector>

namespace tapestry::evaluate {

bool is_found(const std::vector<detect::Detection>& detections, const loss::Target& target,
              double iou_threshold) {
  return std::any_of(detections.begin(), detections.end(), [&](const detect::Detection& detection) {
    return detection.class_index == target.class_index &&
           detect::iou(detection.box, target.box) >= iou_threshold;
  });
}

std::array<double, 2> wilson_interval(std::size_t hits, std::size_t trials, std::size_t pictures_a_trial) {
  if (trials == 0) return {0.0, 1.0};
  constexpr double z = 1.959963984540054;
  const double n = static_cast<double>(trials) / static_cast<double>(pictures_a_trial);
  const double share = static_cast<double>(hits) / static_cast<double>(trials);
  const double centre = share + z * z / (2 * n);
  const double reach = z * std::sqrt(share * (1 - share) / n + z * z / (4 * n * n));
  const double scale = 1 / (1 + z * z / n);
  return {hits == 0 ? 0.0 : scale * (centre - reach), hits == trials ? 1.0 : scale * (centre + reach)};
}

DetectionRate detection_rate(const std::vector<bool>& found, std::size_t pictures_a_view) {
  const auto detected = static_cast<std::size_t>(std::count(found.begin(), found.end(), true));
  if (found.empty()) return {};
  return {found.size(), detected, static_cast<double>(detected) / static_cast<double>(found.size()),
          wilson_interval(detected, found.size(), pictures_a_view)};
}

AttackSuccess attack_success_rate(const std::vector<bool>& clean_found,
                                  const std::vector<bool>& adversarial_found, std::size_t pictures_a_view) {
  if (clean_found.size() != adversarial_found.size())
    throw ShapeError("attack_success_rate: adversarial_found has " +
                     std::to_string(adversarial_found.size()) + " views, expected " +
                     std::to_string(clean_found.size()));
  AttackSuccess success;
  for (std::size_t view = 0; view < clean_found.size(); ++view) {
    if (!clean_found[view]) continue;
    ++success.views;
    if (!adversarial_found[view]) ++success.hidden;
  }
  if (success.views == 0) return success;
  success.rate = static_cast<double>(success.hidden) / static_cast<double>(success.views);
  success.interval = wilson_interval(success.hidden, success.views, pictures_a_view);
  return success;
}

}  // namespace tapestry::evaluate

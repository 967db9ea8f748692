#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/detect/box_decode.hpp>   // Detection
#include <tapestry/detect/box_overlap.hpp>  // iou
#include <tapestry/loss/prediction.hpp>     // Target
#include <vector>

namespace tapestry::evaluate {

/// Whether a detector found a target: some detection has the target's class and an IoU with its box of at
/// least `iou_threshold`.
///
/// \param detections     as they come out of suppression, so above the confidence threshold (0.25 and a
///                       suppression IoU of 0.45 in the reports)
/// \param iou_threshold  0.5 for P@0.5; met exactly counts as found
[[nodiscard]] inline bool is_found(const std::vector<detect::Detection>& detections,
                                   const loss::Target& target, double iou_threshold = 0.5) {
  return std::any_of(detections.begin(), detections.end(), [&](const detect::Detection& detection) {
    return detection.class_index == target.class_index &&
           detect::iou(detection.box, target.box) >= iou_threshold;
  });
}

/// The 95 % interval of a share, from `hits` of `trials`; {0, 1} for no trials.
///
/// Source: Wilson, "Probable inference" (1927), with z = 1.959964. Unlike the normal approximation it never
/// leaves [0, 1] and is honest about 0 of n and n of n.
///
/// \param pictures_a_trial  trials that were looked at several times count once each: their share over all
///                          pictures, which hits and trials then count, is held for that of so many fewer
[[nodiscard]] inline std::array<double, 2> wilson_interval(std::size_t hits, std::size_t trials,
                                                           std::size_t pictures_a_trial = 1) {
  if (trials == 0) return {0.0, 1.0};
  constexpr double z = 1.959963984540054;
  const double n = static_cast<double>(trials) / static_cast<double>(pictures_a_trial);
  const double share = static_cast<double>(hits) / static_cast<double>(trials);
  const double centre = share + z * z / (2 * n);
  const double reach = z * std::sqrt(share * (1 - share) / n + z * z / (4 * n * n));
  const double scale = 1 / (1 + z * z / n);
  return {hits == 0 ? 0.0 : scale * (centre - reach), hits == trials ? 1.0 : scale * (centre + reach)};
}

/// P@0.5: the share of views in which the target was found.
struct DetectionRate {
  std::size_t views = 0;
  std::size_t detected = 0;
  double p_at_50 = 0;                        ///< detected / views, 0 without views; a share, not per cent
  std::array<double, 2> interval{0.0, 1.0};  ///< Wilson, 95 %; all of [0, 1] without views
};

/// \param found            one entry a view, or one a picture
/// \param pictures_a_view  photographs of a view are no further views: the interval counts them as one
[[nodiscard]] inline DetectionRate detection_rate(const std::vector<bool>& found,
                                                  std::size_t pictures_a_view = 1) {
  const auto detected = static_cast<std::size_t>(std::count(found.begin(), found.end(), true));
  if (found.empty()) return {};
  return {found.size(), detected, static_cast<double>(detected) / static_cast<double>(found.size()),
          wilson_interval(detected, found.size(), pictures_a_view)};
}

/// ASR: of the views in which the clean target was found, the share in which the painted one was not.
struct AttackSuccess {
  std::size_t views = 0;                     ///< found in clean; with 0, nothing can be said: report no rate
  std::size_t hidden = 0;                    ///< of those, not found with the adversarial paint
  double rate = 0;                           ///< hidden / views, 0 without views; a share, not per cent
  std::array<double, 2> interval{0.0, 1.0};  ///< Wilson, 95 %; all of [0, 1] without views
};

/// \param clean_found        one entry a view, the car in its own colours
/// \param adversarial_found  the same views with the adversarial paint
/// \param pictures_a_view    as for detection_rate()
/// \throws ShapeError if the two do not have as many views
[[nodiscard]] inline AttackSuccess attack_success_rate(const std::vector<bool>& clean_found,
                                                       const std::vector<bool>& adversarial_found,
                                                       std::size_t pictures_a_view = 1) {
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

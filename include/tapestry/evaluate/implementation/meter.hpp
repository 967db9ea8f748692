#pragma once
#include <algorithm>
#include <concepts>
#include <cstddef>
#include <string>
#include <tapestry/camouflage/view.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/detect/box_decode.hpp>
#include <tapestry/detect/detector.hpp>
#include <tapestry/detect/finite_logits.hpp>
#include <tapestry/detect/pass_pool.hpp>
#include <tapestry/detect/suppression.hpp>
#include <tapestry/evaluate/best_confidence.hpp>
#include <tapestry/evaluate/detection_rate.hpp>
#include <tapestry/evaluate/meter.hpp>
#include <tapestry/image/batch.hpp>
#include <tapestry/loss/prediction.hpp>
#include <utility>
#include <vector>

namespace tapestry::evaluate {

template <std::floating_point T>
ViewResult Meter<T>::examine(const Array<T, 3>& picture, const std::string& name, const detect::Box& target) {
  const auto pass = passes_.take();
  detector_.forward(image::batch_of(picture), *pass);
  const auto& logits = pass->logits;
  detect::require_finite_logits(logits, name);
  double least = settings_.confidence;
  for (const double threshold : settings_.sweep) least = std::min(least, threshold);
  const auto kept = detect::suppress(
      detect::decode(detector_.heads(), logits, 0, least, detector_.input_height(), detector_.input_width()),
      settings_.nms, true, detector_.suppression_measure());
  ViewResult result;
  result.detections = above(settings_.confidence, kept);
  const auto surest =
      std::ranges::find_if(kept, [&](const auto& detection) { return shows_car({detection}, target); });
  if (surest != kept.end()) result.found_confidence = surest->confidence;
  result.found = result.found_confidence > settings_.confidence;
  for (const double threshold : settings_.sweep)
    result.found_in_sweep.push_back(result.found_confidence > threshold);
  result.best_confidence = best_confidence<T>(
      {detector_.heads(), loss::to_read(logits), 0, detector_.input_height(), detector_.input_width()},
      {class_index_, target});
  return result;
}

template <std::floating_point T>
std::vector<detect::Detection> Meter<T>::above(double threshold,
                                               const std::vector<detect::Detection>& detections) {
  const auto is_above = [=](const detect::Detection& detection) { return detection.confidence > threshold; };
  return {detections.begin(), std::partition_point(detections.begin(), detections.end(), is_above)};
}

template class Meter<float>;
template class Meter<double>;

}  // namespace tapestry::evaluate

#pragma once
#include <concepts>
#include <tapestry/detect/best_candidate.hpp>
#include <tapestry/evaluate/best_confidence.hpp>
#include <tapestry/loss/prediction.hpp>

namespace tapestry::evaluate {

template <std::floating_point T>
double best_confidence(const loss::Predictions<T>& predictions, const loss::Target& target,
                       double iou_threshold) {
  const auto best = detect::best_candidate(predictions.heads, predictions.logits, predictions.image,
                                           {target.class_index, target.box, iou_threshold},
                                           predictions.input_height, predictions.input_width);
  return best ? best->confidence : 0;
}

template decltype(best_confidence<float>) best_confidence<float>;
template decltype(best_confidence<double>) best_confidence<double>;

}  // namespace tapestry::evaluate

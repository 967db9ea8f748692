#pragma once
#include <concepts>
#include <cstddef>
#include <memory>
#include <tapestry/loss/prediction_variable.hpp>
#include <tapestry/loss/yolo_training_variable.hpp>  // YoloTrainingVariables
#include <tapestry/loss/yolox_training.hpp>
#include <vector>

namespace tapestry::loss {

/// yolox_training() of a batch on the tape, all terms as one record, with the matches that these logits lead
/// to: what detect::forward() of a graph detector with its constants is trained by.
///
/// \param detector  whose heads gave the logits; not needed after the call
/// \param logits    per head [N, D, H, W]
/// \param truths    one entry an image, boxes in pixels of the network's input
/// \throws as dynamic_matches()
template <Detector D, std::floating_point T>
[[nodiscard]] YoloTrainingVariables<T> yolox_training(const D& detector,
                                                      const std::vector<ArrayVariable<T, 4>>& logits,
                                                      const Truths& truths,
                                                      const YoloxTrainingOptions& options = {}) {
  const auto kept = std::make_shared<const detail::KeptLogits<T>>(detector, logits);
  const std::size_t height = kept->input_height(), width = kept->input_width();
  const auto matches = std::make_shared<const DynamicMatches>(
      dynamic_matches(kept->heads(), kept->view(), truths, height, width, options.match));
  const auto terms = yolox_training(kept->heads(), kept->view(), *matches, height, width, options);
  const auto adjoint_of = [kept, matches, height, width](const YoloxTrainingOptions& weights,
                                                         const LogitsAdjoint<T>& logits_adjoint) {
    yolox_training_adjoint(kept->heads(), kept->view(), *matches, height, width, weights, T(1),
                           logits_adjoint);
  };
  return detail::record_training_terms(terms, options, adjoint_of, logits);
}

}  // namespace tapestry::loss

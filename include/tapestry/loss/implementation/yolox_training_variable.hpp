#pragma once
#include <concepts>
#include <cstddef>
#include <memory>
#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/loss/implementation/yolo_training_variable.hpp>
#include <tapestry/loss/prediction_variable.hpp>
#include <tapestry/loss/yolo_training_variable.hpp>
#include <tapestry/loss/yolox_training.hpp>
#include <tapestry/loss/yolox_training_variable.hpp>
#include <vector>

namespace tapestry::loss::detail {

template <class T>
YoloTrainingVariables<T> yolox_training_of(const std::vector<detect::Head>& heads, std::size_t input_height,
                                           std::size_t input_width,
                                           const std::vector<ArrayVariable<T, 4>>& logits,
                                           const Truths& truths, const YoloxTrainingOptions& options) {
  const auto kept = std::make_shared<const KeptLogits<T>>(heads, input_height, input_width, logits);
  const auto matches = std::make_shared<const DynamicMatches>(
      dynamic_matches(kept->heads(), kept->view(), truths, input_height, input_width, options.match));
  const auto terms =
      yolox_training(kept->heads(), kept->view(), *matches, input_height, input_width, options);
  const auto adjoint_of = [kept, matches, input_height, input_width](const YoloxTrainingOptions& weights,
                                                                     const LogitsAdjoint<T>& logits_adjoint) {
    yolox_training_adjoint(kept->heads(), kept->view(), *matches, input_height, input_width, weights, T(1),
                           logits_adjoint);
  };
  return record_training_terms(terms, options, adjoint_of, logits);
}

template decltype(yolox_training_of<float>) yolox_training_of<float>;
template decltype(yolox_training_of<double>) yolox_training_of<double>;

}  // namespace tapestry::loss::detail

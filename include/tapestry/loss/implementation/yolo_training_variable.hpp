#pragma once
#include <concepts>
#include <cstddef>
#include <memory>
#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/loss/prediction_variable.hpp>
#include <tapestry/loss/yolo_training.hpp>
#include <tapestry/loss/yolo_training_variable.hpp>
#include <vector>

namespace tapestry::loss::detail {

/// The terms of a training loss on the tape, as one record.
/// \param options     with the weights of the terms
/// \param adjoint_of  adds to its second argument the derivative of the total under the weights of its first
template <class T, class Options, class AdjointOf>
[[nodiscard]] YoloTrainingVariables<T> record_training_terms(const YoloTrainingTerms& terms,
                                                             const Options& options, AdjointOf adjoint_of,
                                                             const std::vector<ArrayVariable<T, 4>>& logits) {
  const auto pullback = [options, adjoint_of](const Array<T, 1>& terms_adjoint,
                                              const LogitsAdjoint<T>& logits_adjoint) {
    const auto adjoint = [&](std::size_t term) { return static_cast<double>(terms_adjoint(term)); };
    Options weights = options;  // of each term what its own adjoint and the total's ask for
    weights.box = adjoint(0) + adjoint(3) * options.box;
    weights.objectness = adjoint(1) + adjoint(3) * options.objectness;
    weights.classification = adjoint(2) + adjoint(3) * options.classification;
    adjoint_of(weights, logits_adjoint);
  };
  const ArrayVariable<T, 1> values =
      record_array(Array<T, 1>{static_cast<T>(terms.box), static_cast<T>(terms.objectness),
                               static_cast<T>(terms.classification), static_cast<T>(terms.total)},
                   pullback, logits);
  return {element(values, {0}), element(values, {1}), element(values, {2}), element(values, {3})};
}

template <class T>
YoloTrainingVariables<T> yolo_training_of(const std::vector<detect::Head>& heads, std::size_t input_height,
                                          std::size_t input_width,
                                          const std::vector<ArrayVariable<T, 4>>& logits,
                                          const Truths& truths, const YoloTrainingOptions& options) {
  const auto kept = std::make_shared<const KeptLogits<T>>(heads, input_height, input_width, logits);
  const auto means =
      yolo_training(kept->heads(), kept->view(), truths, kept->input_height(), kept->input_width(), options);
  const auto adjoint_of = [kept, truths](const YoloTrainingOptions& weights,
                                         const LogitsAdjoint<T>& logits_adjoint) {
    yolo_training_adjoint(kept->heads(), kept->view(), truths, kept->input_height(), kept->input_width(),
                          weights, T(1), logits_adjoint);
  };
  return record_training_terms(means, options, adjoint_of, logits);
}

template decltype(yolo_training_of<float>) yolo_training_of<float>;
template decltype(yolo_training_of<double>) yolo_training_of<double>;

}  // namespace tapestry::loss::detail

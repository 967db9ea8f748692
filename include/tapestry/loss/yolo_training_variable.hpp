#pragma once
#include <concepts>
#include <cstddef>
#include <memory>
#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/loss/prediction_variable.hpp>
#include <tapestry/loss/yolo_training.hpp>
#include <vector>

namespace tapestry::loss {

/// YoloTrainingTerms on the tape.
template <class T>
struct YoloTrainingVariables {
  Variable<T> box, objectness, classification;
  Variable<T> total;
};

/// yolo_training() of a batch on the tape, all terms as one record: what detect::forward() of a network with
/// its parameters is trained by.
///
/// \param detector  whose heads gave the logits; not needed after the call
/// \param logits    per head [N, A·(5+K), H, W]
/// \param truths    one entry an image, boxes in pixels of the network's input
/// \throws as yolo_training()
template <Detector D, std::floating_point T>
[[nodiscard]] YoloTrainingVariables<T> yolo_training(const D& detector,
                                                     const std::vector<ArrayVariable<T, 4>>& logits,
                                                     const Truths& truths,
                                                     const YoloTrainingOptions& options = {}) {
  const auto kept = std::make_shared<const detail::KeptLogits<T>>(detector, logits);
  const auto means =
      yolo_training(kept->heads(), kept->view(), truths, kept->input_height(), kept->input_width(), options);
  const auto pullback = [kept, truths, options](const Array<T, 1>& means_adjoint,
                                                const LogitsAdjoint<T>& logits_adjoint) {
    const auto adjoint = [&](std::size_t term) { return static_cast<double>(means_adjoint(term)); };
    YoloTrainingOptions weights = options;  // of each term what its own adjoint and the total's ask for
    weights.box = adjoint(0) + adjoint(3) * options.box;
    weights.objectness = adjoint(1) + adjoint(3) * options.objectness;
    weights.classification = adjoint(2) + adjoint(3) * options.classification;
    yolo_training_adjoint(kept->heads(), kept->view(), truths, kept->input_height(), kept->input_width(),
                          weights, T(1), logits_adjoint);
  };
  const ArrayVariable<T, 1> terms =
      record_array(Array<T, 1>{static_cast<T>(means.box), static_cast<T>(means.objectness),
                               static_cast<T>(means.classification), static_cast<T>(means.total)},
                   pullback, logits);
  return {element(terms, {0}), element(terms, {1}), element(terms, {2}), element(terms, {3})};
}

}  // namespace tapestry::loss

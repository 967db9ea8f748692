#pragma once
#include <concepts>
#include <cstddef>
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/autodiff/variable.hpp>
#include <tapestry/detect/head.hpp>
#include <tapestry/loss/prediction.hpp>
#include <tapestry/loss/yolo_training.hpp>
#include <vector>

namespace tapestry::loss {

/// YoloTrainingTerms on the tape.
template <class T>
struct YoloTrainingVariables {
  Variable<T> box, objectness, classification;
  Variable<T> total;
};

namespace detail {

/// yolo_training() of the logits of these heads.
template <class T>
[[nodiscard]] YoloTrainingVariables<T> yolo_training_of(const std::vector<detect::Head>& heads,
                                                        std::size_t input_height, std::size_t input_width,
                                                        const std::vector<ArrayVariable<T, 4>>& logits,
                                                        const Truths& truths,
                                                        const YoloTrainingOptions& options);

}  // namespace detail

/// yolo_training() of a batch on the tape, all terms as one record: what detect::forward() of a network with
/// its parameters is trained by.
///
/// \param detector  whose heads gave the logits; not needed after the call
/// \param logits    per head [N, A·(5+K), H, W]
/// \param truths    one entry an image, boxes in pixels of the network's input
/// \throws as yolo_training()
template <DetectorLike D, std::floating_point T>
[[nodiscard]] YoloTrainingVariables<T> yolo_training(const D& detector,
                                                     const std::vector<ArrayVariable<T, 4>>& logits,
                                                     const Truths& truths,
                                                     const YoloTrainingOptions& options = {}) {
  return detail::yolo_training_of<T>(detector.heads(), detector.input_height(), detector.input_width(),
                                     logits, truths, options);
}

}  // namespace tapestry::loss

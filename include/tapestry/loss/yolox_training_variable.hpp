#pragma once
#include <concepts>
#include <cstddef>
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/detect/head.hpp>
#include <tapestry/loss/prediction.hpp>
#include <tapestry/loss/yolo_training_variable.hpp>  // YoloTrainingVariables
#include <tapestry/loss/yolox_training.hpp>
#include <vector>

namespace tapestry::loss {
namespace detail {

/// yolox_training() of the logits of these heads.
template <class T>
[[nodiscard]] YoloTrainingVariables<T> yolox_training_of(const std::vector<detect::Head>& heads,
                                                         std::size_t input_height, std::size_t input_width,
                                                         const std::vector<ArrayVariable<T, 4>>& logits,
                                                         const Truths& truths,
                                                         const YoloxTrainingOptions& options);

}  // namespace detail

/// yolox_training() of a batch on the tape, all terms as one record, with the matches that these logits lead
/// to: what detect::forward() of a graph detector with its constants is trained by.
///
/// \param detector  whose heads gave the logits; not needed after the call
/// \param logits    per head [N, D, H, W]
/// \param truths    one entry an image, boxes in pixels of the network's input
/// \throws as dynamic_matches()
template <DetectorLike D, std::floating_point T>
[[nodiscard]] YoloTrainingVariables<T> yolox_training(const D& detector,
                                                      const std::vector<ArrayVariable<T, 4>>& logits,
                                                      const Truths& truths,
                                                      const YoloxTrainingOptions& options = {}) {
  return detail::yolox_training_of<T>(detector.heads(), detector.input_height(), detector.input_width(),
                                      logits, truths, options);
}

}  // namespace tapestry::loss

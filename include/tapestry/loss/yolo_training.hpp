#pragma once
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/autodiff/variable.hpp>
#include <tapestry/loss/prediction.hpp>

namespace tapestry::loss {
/// The terms of the loss a detector is trained with, before weighting, and their weighted sum.
struct YoloTrainingTerms {
  double box = 0, objectness = 0, classification = 0;
  double total = 0;
};

namespace detail {
/// The terms of a batch: its images are computed side by side, summed in order and divided by `count`.
/// \param options   with a weight of each term
/// \param of_image  the terms of an image, called with its number
template <class Options, std::invocable<std::size_t> OfImage>
YoloTrainingTerms batch_terms(std::size_t images, double count, const Options& options, OfImage of_image) {
  std::vector<YoloTrainingTerms> per_image(images);
  parallel_for(images, [&](std::size_t n) { per_image[n] = of_image(n); });
  YoloTrainingTerms terms;
  for (const auto& one : per_image) {
    terms.box += one.box / count;
    terms.objectness += one.objectness / count;
    terms.classification += one.classification / count;
  }
  terms.total = options.box * terms.box + options.objectness * terms.objectness +
                options.classification * terms.classification;
  return terms;
}
}  // namespace detail

/// Cross entropy of a candidate with one class: Σ_k H(t_k, [k is it]), see binary_cross_entropy(), or for
/// exclusive classes −log of its softmax.
template <std::floating_point T>
[[nodiscard]] double class_entropy(const Predictions<T>& predictions, const Candidate& candidate,
                                   std::size_t class_index) {
  const auto& head = predictions.heads[candidate.head];
  if (head.exclusive_classes) return softplus(-class_logit(predictions, candidate, class_index));
  double sum = 0;
  for (std::size_t k = 0; k < head.classes; ++k)
    sum +=
        binary_cross_entropy(logit(predictions, candidate, head.class_channel(k)), k == class_index ? 1 : 0);
  return sum;
}

/// Adds loss_adjoint times the derivative of class_entropy().
template <std::floating_point T>
void class_entropy_adjoint(const Predictions<T>& predictions, const Candidate& candidate,
                           std::size_t class_index, double loss_adjoint,
                           const LogitsAdjoint<T>& logits_adjoint) {
  const auto& head = predictions.heads[candidate.head];
  if (head.exclusive_classes) {
    const double missed = nn::logistic(-class_logit(predictions, candidate, class_index));
    class_logit_adjoint(predictions, candidate, class_index, -loss_adjoint * missed, logits_adjoint);
    return;
  }
  for (std::size_t k = 0; k < head.classes; ++k) {
    const std::size_t channel = head.class_channel(k);
    const double slope =
        binary_cross_entropy_slope(logit(predictions, candidate, channel), k == class_index ? 1 : 0);
    add_to_logit(predictions, candidate, channel, loss_adjoint * slope, logits_adjoint);
  }
}

/// Thresholds and weights of the training of a YOLO-V3 detector.
struct YoloTrainingOptions {
  double ignore_iou = 0.5;  ///< unmatched boxes that overlap a truth by more are ignored
  double match_iou =
      1.0;  ///< anchors whose shape overlaps the truth's by more are matched beside the best one
  double box = 1.0, objectness = 1.0, classification = 1.0;  ///< weights of the terms
};

/// The loss a YOLO-V3 detector is trained with, a mean over the images of
///
///   Σ matched     (2 − area) · (H(tx, x) + H(ty, y) + ½(tw − w)² + ½(th − h)²)
///                 + H(to, 1) + Σ_k H(tk, [k is it])
///   Σ unmatched   H(to, 0), without boxes that overlap a truth by more than ignore_iou
///
/// H(t, p) being the cross entropy of σ(t) with the wanted p, x and y the truth's place within its cell
/// (corrected for scale_x_y), w and h the log of its size over the anchor's. Classes are independent of each
/// other; exclusive ones (YOLOv2) have −log of the softmax of the truth's class in place of Σ_k. Which
/// candidates are matched and which are ignored is not differentiated. Source: Redmon and Farhadi, "YOLOv3"
/// (2018), section 2, with the cross entropy for x and y too.
///
/// Heads of the ultralytics family have H(tw, w) + H(th, h) instead of the squares, w and h being half the
/// root of the truth's size over the anchor's, at most 1: their boxes end at 4 anchors. Their decode family
/// takes this loss, not the complete IoU that they were trained with.
///
/// \param logits  per head [N, A·(5+K), H, W]
/// \param truths  one entry an image, boxes in pixels of the network's input
/// \throws ShapeError, DomainError as adversarial(), also for heads of the decode family scaled; DomainError
///         for heads without anchors
template <std::floating_point T>
[[nodiscard]] YoloTrainingTerms yolo_training(const std::vector<detect::Head>& heads,
                                              const LogitsView<T>& logits, const Truths& truths,
                                              std::size_t input_height, std::size_t input_width,
                                              const YoloTrainingOptions& options = {});

/// Adds total_adjoint · ∂total/∂logits; arguments otherwise as in yolo_training().
template <std::floating_point T>
void yolo_training_adjoint(const std::vector<detect::Head>& heads, const LogitsView<T>& logits,
                           const Truths& truths, std::size_t input_height, std::size_t input_width,
                           const YoloTrainingOptions& options, T total_adjoint,
                           const LogitsAdjoint<T>& logits_adjoint);

/// YoloTrainingTerms on the tape.
template <std::floating_point T>
struct YoloTrainingVariables {
  Variable<T> box, objectness, classification;
  Variable<T> total;
};

namespace detail {
/// yolo_training() of the logits of these heads.
template <std::floating_point T>
[[nodiscard]] YoloTrainingVariables<T> yolo_training_of(const std::vector<detect::Head>& heads,
                                                        std::size_t input_height, std::size_t input_width,
                                                        const std::vector<ArrayVariable<T, 4>>& logits,
                                                        const Truths& truths,
                                                        const YoloTrainingOptions& options);
}  // namespace detail

/// yolo_training() of a batch on the tape, all terms as one record, to train the parameters that
/// detect::forward() takes.
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

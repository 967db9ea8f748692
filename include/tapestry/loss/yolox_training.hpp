#pragma once
#include <tapestry/loss/detail/box_assignment.hpp>
#include <tapestry/loss/yolo_training.hpp>  // YoloTrainingVariables

namespace tapestry::loss {
/// Weights of the training of a detector without anchors.
struct YoloxTrainingOptions {
  DynamicMatchOptions match{};
  double box = 5.0, objectness = 1.0, classification = 1.0;  ///< weights of the terms
};

/// The loss a YOLOX detector is trained with, for candidates that are matched with truths. With the logits t,
/// H(t, p) the cross entropy of σ(t) with p, IoU of the box and the truth's box, and iou the
/// constant IoU at matching,
///
///   box             Σ matched   1 − IoU²
///   objectness      Σ all       H(to, [is matched])
///   classification  Σ matched   Σ_k H(tk, [k is it] · iou)
///
/// each over all images and divided by the number of matched candidates, or by 1 if there are none. Source:
/// Ge et al., "YOLOX: exceeding YOLO series in 2021" (arXiv 2107.08430), without the L1 loss of its last
/// epochs.
///
/// Heads of the family distance have no objectness, and a class score measures how good its box is:
///
///   classification  Σ all   Σ_k (y − σ(tk))² · H(tk, y),  y = [is matched, and k is it] · iou
///
/// the quality focal loss of Li et al., "Generalized Focal Loss" (NeurIPS 2020). Their distribution focal
/// loss is left out: the bins learn through the box alone. So it is a loss for fine-tuning, where the bins
/// already have a shape.
///
/// \param logits   per head [N, D, H, W]
/// \param matches  of these logits or others of the same heads, see dynamic_matches(); one entry an image
/// \throws ShapeError, DomainError as adversarial(), and DomainError for heads of other families than yolox
///         and distance
template <std::floating_point T>
[[nodiscard]] YoloTrainingTerms yolox_training(const std::vector<detect::Head>& heads,
                                               const LogitsView<T>& logits, const DynamicMatches& matches,
                                               std::size_t input_height, std::size_t input_width,
                                               const YoloxTrainingOptions& options = {});

/// Adds total_adjoint · ∂total/∂logits; arguments otherwise as in yolox_training(). A box that does not meet
/// its truth has no slope, and where edges coincide the slope is as in iou_with_gradient().
template <std::floating_point T>
void yolox_training_adjoint(const std::vector<detect::Head>& heads, const LogitsView<T>& logits,
                            const DynamicMatches& matches, std::size_t input_height, std::size_t input_width,
                            const YoloxTrainingOptions& options, T total_adjoint,
                            const LogitsAdjoint<T>& logits_adjoint);

namespace detail {
/// yolox_training() of the logits of these heads.
template <std::floating_point T>
[[nodiscard]] YoloTrainingVariables<T> yolox_training_of(const std::vector<detect::Head>& heads,
                                                         std::size_t input_height, std::size_t input_width,
                                                         const std::vector<ArrayVariable<T, 4>>& logits,
                                                         const Truths& truths,
                                                         const YoloxTrainingOptions& options);
}  // namespace detail

/// yolox_training() of a batch on the tape, all terms as one record, with the matches for these logits, to
/// train the weights that detect::forward() takes.
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

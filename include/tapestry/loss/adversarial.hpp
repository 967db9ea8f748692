#pragma once
#include <tapestry/loss/detail/adversarial_second_order.hpp>
#include <tapestry/loss/detail/adversarial_terms.hpp>

/// \file
/// The first header of loss/: the terms that optimisations minimise, as a sum Σ weight · term.
///
///   of logits, by paint     adversarial.hpp                          hides a car from a detector
///   of logits, by weights   yolo_training.hpp, yolox_training.hpp    trains a detector
///   of a heat map           attention.hpp                            scatters a detector's attention
///   of texels               smoothness.hpp,
///                           printability.hpp                         keeps a paint printable
///   of positions            mesh_regularity.hpp                      keeps a mesh regular
///
/// Read next: prediction.hpp, responsible.hpp, adversarial_terms.hpp.

namespace tapestry::loss {
namespace detail {
struct TermSums {
  double iou = 0, objectness = 0, classification = 0, max_score = 0;
};

template <std::floating_point T>
void terms_adjoint(const Predictions<T>& predictions, const Target& target, AdversarialLoss kind,
                   const TermSums& adjoint, const LogitsAdjoint<T>& logits_adjoint);

/// adversarial() of the logits of these heads.
template <std::floating_point T>
[[nodiscard]] AdversarialTerms<Variable<T>> adversarial_of(const std::vector<detect::Head>& heads,
                                                           std::size_t input_height, std::size_t input_width,
                                                           const std::vector<ArrayVariable<T, 4>>& logits,
                                                           std::span<const Target> targets,
                                                           AdversarialLoss kind,
                                                           const AdversarialWeights& weights);
}  // namespace detail

/// The loss that is minimised so that one image's target is not found, on the raw logits of the heads.
///
/// Defined throughout: 0 exactly when no box meets the target (paper, max_score, vanish); a box that is
/// degenerate or too large to be measured has IoU 0 and no gradient; logits of ±100 give finite values; NaN
/// logits give a NaN total, whichever candidate they belong to (as_coded: NaN logits of box and class only at
/// matched candidates, since it reads no others). The target may reach over the border of the picture, or lie
/// outside: boxes are compared whole, and as_coded then has no match. Sums are in double whatever T is.
///
/// \throws ShapeError if logits and heads do not fit each other; DomainError if there is no such image or
///         class, the target box is not finite, or a head gives no raw logits, see require_raw_logits()
template <std::floating_point T>
[[nodiscard]] AdversarialTerms<T> adversarial(const Predictions<T>& predictions, const Target& target,
                                              AdversarialLoss kind, const AdversarialWeights& weights = {});

/// Adds total_adjoint · ∂total/∂logits to logits_adjoint, which has the shapes of the logits. At a kink (two
/// candidates with equal score, coinciding edges of boxes, a mean logit of 0) it takes the value documented
/// there. Only the image of the predictions is changed.
/// \throws as adversarial(), and ShapeError if logits_adjoint does not fit
template <std::floating_point T>
void adversarial_adjoint(const Predictions<T>& predictions, const Target& target, AdversarialLoss kind,
                         const AdversarialWeights& weights, T total_adjoint,
                         const LogitsAdjoint<T>& logits_adjoint);

/// adversarial() of a batch on the tape: every term is the mean over the images of its value, and total
/// the mean of their weighted sums; all are one record, whose pullback is adversarial_adjoint(). Images run
/// in parallel and are added in order: the same bits for any number of threads.
///
/// \param detector  whose heads gave the logits; not needed after the call
/// \param logits    per head [N, A·D, H, W], see detect::Head, as of detect::forward()
/// \param targets   one an image
/// \throws DomainError if there are no targets, ShapeError if their number is not that of images;
///         otherwise as adversarial()
template <DetectorLike D, std::floating_point T>
[[nodiscard]] AdversarialTerms<Variable<T>> adversarial(const D& detector,
                                                        const std::vector<ArrayVariable<T, 4>>& logits,
                                                        std::span<const Target> targets,
                                                        AdversarialLoss kind = AdversarialLoss::paper,
                                                        const AdversarialWeights& weights = {}) {
  return detail::adversarial_of<T>(detector.heads(), detector.input_height(), detector.input_width(), logits,
                                   targets, kind, weights);
}

/// The same on a tape of duals. \throws DomainError for as_coded, whose second order is not known
template <DetectorLike Of, DualNumber D>
[[nodiscard]] AdversarialTerms<Variable<D>> adversarial(const Of& detector,
                                                        const std::vector<ArrayVariable<D, 4>>& logits,
                                                        std::span<const Target> targets,
                                                        AdversarialLoss kind = AdversarialLoss::paper,
                                                        const AdversarialWeights& weights = {}) {
  return detail::adversarial_of_duals<D>(detector.heads(), detector.input_height(), detector.input_width(),
                                         logits, targets, kind, weights);
}

/// Means of the terms of several detectors, at least one, on the tape.
template <std::floating_point T>
[[nodiscard]] AdversarialTerms<Variable<T>> mean_of(std::vector<AdversarialTerms<Variable<T>>> terms);
}  // namespace tapestry::loss

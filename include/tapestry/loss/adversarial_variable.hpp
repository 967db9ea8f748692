#pragma once
#include <concepts>
#include <cstddef>
#include <span>
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/autodiff/variable.hpp>
#include <tapestry/detect/head.hpp>
#include <tapestry/loss/adversarial.hpp>
#include <tapestry/loss/prediction.hpp>
#include <vector>

namespace tapestry::loss {
namespace detail {

/// adversarial() of the logits of these heads.
template <class T>
[[nodiscard]] AdversarialTerms<Variable<T>> adversarial_of(const std::vector<detect::Head>& heads,
                                                           std::size_t input_height, std::size_t input_width,
                                                           const std::vector<ArrayVariable<T, 4>>& logits,
                                                           std::span<const Target> targets,
                                                           AdversarialLoss kind,
                                                           const AdversarialWeights& weights);

}  // namespace detail

/// adversarial() of a batch on the tape: every term is the mean over the images of its value, and total
/// the mean of their weighted sums; all are one record, whose pullback is adversarial_adjoint(). Images run
/// in parallel and are added in order: the same bits for any number of threads.
///
/// \param detector  whose heads gave the logits; not needed after the call
/// \param logits    per head [N, A·D, H, W], see detect::Head, as of detect::forward()
/// \param targets   one an image
/// \throws DomainError if there are no targets, ShapeError if they are not as many as the images; otherwise
///         as adversarial()
template <DetectorLike D, std::floating_point T>
[[nodiscard]] AdversarialTerms<Variable<T>> adversarial(const D& detector,
                                                        const std::vector<ArrayVariable<T, 4>>& logits,
                                                        std::span<const Target> targets,
                                                        AdversarialLoss kind = AdversarialLoss::paper,
                                                        const AdversarialWeights& weights = {}) {
  return detail::adversarial_of<T>(detector.heads(), detector.input_height(), detector.input_width(), logits,
                                   targets, kind, weights);
}

/// Means of the terms of several detectors, at least one, on the tape.
template <std::floating_point T>
[[nodiscard]] AdversarialTerms<Variable<T>> mean_of(std::vector<AdversarialTerms<Variable<T>>> terms);

}  // namespace tapestry::loss

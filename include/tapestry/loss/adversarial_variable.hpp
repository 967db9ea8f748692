#pragma once
#include <concepts>
#include <cstddef>
#include <memory>
#include <span>
#include <tapestry/autodiff/arrays/gather.hpp>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/loss/adversarial.hpp>
#include <tapestry/loss/prediction_variable.hpp>
#include <vector>

namespace tapestry::loss {
namespace detail {

/// The mean of the terms over a batch, added in double in the order of the images: iou, objectness,
/// classification, max_score, total.
template <class T>
[[nodiscard]] Array<T, 1> mean_adversarial_terms(const KeptLogits<T>& logits, std::span<const Target> targets,
                                                 AdversarialLoss kind, const AdversarialWeights& weights);

/// What one image's terms get of the adjoint of the means.
template <class T>
[[nodiscard]] TermSums adjoint_of_terms(const Array<T, 1>& means_adjoint, std::size_t images,
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
template <Detector D, std::floating_point T>
[[nodiscard]] AdversarialTerms<Variable<T>> adversarial(const D& detector,
                                                        const std::vector<ArrayVariable<T, 4>>& logits,
                                                        std::span<const Target> targets,
                                                        AdversarialLoss kind = AdversarialLoss::paper,
                                                        const AdversarialWeights& weights = {}) {
  const auto kept = std::make_shared<const detail::KeptLogits<T>>(detector, logits);
  require_batch("adversarial", "targets", targets.size(), kept->view());
  const auto pullback = [kept, kind, weights,
                         of_images = std::vector<Target>(targets.begin(), targets.end())](
                            const Array<T, 1>& means_adjoint, const LogitsAdjoint<T>& logits_adjoint) {
    const auto adjoint = detail::adjoint_of_terms(means_adjoint, of_images.size(), weights);
    parallel_for(of_images.size(), [&](std::size_t n) {
      detail::terms_adjoint(kept->of_image(n), of_images[n], kind, adjoint, logits_adjoint);
    });
  };
  const ArrayVariable<T, 1> means =
      record_array(detail::mean_adversarial_terms(*kept, targets, kind, weights), pullback, logits);
  const auto term = [&](std::size_t index) { return element(means, {index}); };
  return {term(0), term(1), term(2), term(3), term(4)};
}

/// Means of the terms of several detectors, at least one, on the tape.
template <std::floating_point T>
[[nodiscard]] AdversarialTerms<Variable<T>> mean_of(std::vector<AdversarialTerms<Variable<T>>> terms);

}  // namespace tapestry::loss

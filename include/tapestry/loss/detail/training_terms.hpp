#pragma once
#include <tapestry/core/parallel.hpp>
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

}  // namespace tapestry::loss

#pragma once
#include <concepts>
#include <cstddef>
#include <memory>
#include <span>
#include <tapestry/autodiff/arrays/gather.hpp>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/loss/adversarial.hpp>
#include <tapestry/loss/adversarial_variable.hpp>
#include <tapestry/loss/prediction_variable.hpp>
#include <vector>

namespace tapestry::loss::detail {

/// The mean of the terms over a batch, added in double in the order of the images: iou, objectness,
/// classification, max_score, total.
template <class T>
Array<T, 1> mean_adversarial_terms(const KeptLogits<T>& logits, std::span<const Target> targets,
                                   AdversarialLoss kind, const AdversarialWeights& weights) {
  std::vector<AdversarialTerms<T>> terms(targets.size());
  parallel_for(targets.size(),
               [&](std::size_t n) { terms[n] = adversarial(logits.of_image(n), targets[n], kind, weights); });
  const double share = 1 / static_cast<double>(targets.size());
  const auto mean = [&](T AdversarialTerms<T>::*member) {
    double sum = 0;
    for (const auto& of_image : terms) sum += share * static_cast<double>(of_image.*member);
    return static_cast<T>(sum);
  };
  using Terms = AdversarialTerms<T>;
  return {mean(&Terms::iou), mean(&Terms::objectness), mean(&Terms::classification), mean(&Terms::max_score),
          mean(&Terms::total)};
}

/// Adjoint of one image's terms, a share of that of the means.
template <class T>
TermSums adjoint_of_terms(const Array<T, 1>& means_adjoint, std::size_t images,
                          const AdversarialWeights& weights) {
  const T share = static_cast<T>(1 / static_cast<double>(images));
  const auto of_image = [&](std::size_t term) {
    return static_cast<double>(means_adjoint.data()[term] * share);
  };
  const double total = of_image(4);
  return {of_image(0) + total * weights.iou, of_image(1) + total * weights.objectness,
          of_image(2) + total * weights.classification, of_image(3) + total * weights.max_score};
}

template <class T>
AdversarialTerms<Variable<T>> adversarial_of(const std::vector<detect::Head>& heads, std::size_t input_height,
                                             std::size_t input_width,
                                             const std::vector<ArrayVariable<T, 4>>& logits,
                                             std::span<const Target> targets, AdversarialLoss kind,
                                             const AdversarialWeights& weights) {
  const auto kept = std::make_shared<const KeptLogits<T>>(heads, input_height, input_width, logits);
  require_batch("adversarial", "targets", targets.size(), kept->view());
  const auto pullback = [kept, kind, weights,
                         of_images = std::vector<Target>(targets.begin(), targets.end())](
                            const Array<T, 1>& means_adjoint, const LogitsAdjoint<T>& logits_adjoint) {
    const auto adjoint = adjoint_of_terms(means_adjoint, of_images.size(), weights);
    parallel_for(of_images.size(), [&](std::size_t n) {
      terms_adjoint(kept->of_image(n), of_images[n], kind, adjoint, logits_adjoint);
    });
  };
  const ArrayVariable<T, 1> means =
      record_array(mean_adversarial_terms(*kept, targets, kind, weights), pullback, logits);
  const auto term = [&](std::size_t index) { return element(means, {index}); };
  return {term(0), term(1), term(2), term(3), term(4)};
}

}  // namespace tapestry::loss::detail

namespace tapestry::loss {

template <std::floating_point T>
AdversarialTerms<Variable<T>> mean_of(std::vector<AdversarialTerms<Variable<T>>> terms) {
  using Terms = AdversarialTerms<Variable<T>>;
  Terms mean = std::move(terms.front());
  if (terms.size() == 1) return mean;
  for (const auto term :
       {&Terms::iou, &Terms::objectness, &Terms::classification, &Terms::max_score, &Terms::total}) {
    for (std::size_t i = 1; i < terms.size(); ++i) mean.*term += terms[i].*term;
    mean.*term /= static_cast<T>(terms.size());
  }
  return mean;
}

}  // namespace tapestry::loss

namespace tapestry::loss::detail {

template decltype(adversarial_of<float>) adversarial_of<float>;
template decltype(adversarial_of<double>) adversarial_of<double>;

}  // namespace tapestry::loss::detail

namespace tapestry::loss {

template decltype(mean_of<float>) mean_of<float>;
template decltype(mean_of<double>) mean_of<double>;

}  // namespace tapestry::loss

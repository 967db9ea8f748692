#pragma once
#include <tapestry/loss/adversarial.hpp>
#include <tapestry/loss/detail/prediction_variable.hpp>

namespace tapestry::loss {
namespace detail {
template <std::floating_point T>
TermSums paper_terms(const Predictions<T>& predictions, const Target& target) {
  TermSums sums;
  for (std::size_t head = 0; head < predictions.heads.size(); ++head) {
    const auto found = responsible(predictions, head, target);
    if (!found) continue;
    sums.iou += found->overlap.iou;
    sums.objectness += found->objectness;
    sums.classification += found->class_probability;
  }
  return sums;
}

template <std::floating_point T>
void paper_terms_adjoint(const Predictions<T>& predictions, const Target& target, const TermSums& adjoint,
                         const LogitsAdjoint<T>& logits_adjoint) {
  for (std::size_t head = 0; head < predictions.heads.size(); ++head) {
    const auto found = responsible(predictions, head, target);
    if (!found) continue;
    const auto& layout = predictions.heads[head];
    const std::size_t objectness = objectness_channel(layout, target.class_index);
    add_to_logit(predictions, found->candidate, objectness,
                 adjoint.objectness * logistic_slope(logit(predictions, found->candidate, objectness)),
                 logits_adjoint);
    const double of_class = class_logit(predictions, found->candidate, target.class_index);
    class_logit_adjoint(predictions, found->candidate, target.class_index,
                        adjoint.classification * logistic_slope(of_class), logits_adjoint);
    detect::Box box_adjoint{0, 0, 0, 0};
    add(box_adjoint, found->overlap.gradient, adjoint.iou);
    decoded_box_adjoint(predictions, found->candidate, box_adjoint, logits_adjoint);
  }
}

template <std::floating_point T>
TermSums as_coded_terms(const Predictions<T>& predictions, const Target& target) {
  TermSums sums;
  const auto balance = objectness_balance(predictions.heads);
  for (std::size_t head = 0; head < predictions.heads.size(); ++head) {
    const auto matched = matched_candidates(predictions, head, target);
    for (const Candidate& candidate : matched)
      sums.iou += complete_iou(decoded_box(predictions, candidate), target.box).value() /
                  static_cast<double>(matched.size());
    sums.objectness +=
        balance[head] * mean_objectness_entropy(predictions, head, matched, target.class_index);
    sums.classification += largest_mean_logit(predictions, matched, target.class_index);
  }
  return sums;
}

template <std::floating_point T>
void as_coded_terms_adjoint(const Predictions<T>& predictions, const Target& target, const TermSums& adjoint,
                            const LogitsAdjoint<T>& logits_adjoint) {
  const auto balance = objectness_balance(predictions.heads);
  for (std::size_t head = 0; head < predictions.heads.size(); ++head) {
    const auto matched = matched_candidates(predictions, head, target);
    for (const Candidate& candidate : matched) {
      detect::Box box_adjoint{0, 0, 0, 0};
      add(box_adjoint, complete_iou(decoded_box(predictions, candidate), target.box).gradient,
          adjoint.iou / static_cast<double>(matched.size()));
      decoded_box_adjoint(predictions, candidate, box_adjoint, logits_adjoint);
    }
    mean_objectness_entropy_adjoint(predictions, head, matched, target.class_index,
                                    adjoint.objectness * balance[head], logits_adjoint);
    largest_mean_logit_adjoint(predictions, matched, target.class_index, adjoint.classification,
                               logits_adjoint);
  }
}

template <std::floating_point T>
void terms_adjoint(const Predictions<T>& predictions, const Target& target, AdversarialLoss kind,
                   const TermSums& adjoint, const LogitsAdjoint<T>& logits_adjoint) {
  if (kind == AdversarialLoss::paper) paper_terms_adjoint(predictions, target, adjoint, logits_adjoint);
  if (kind == AdversarialLoss::as_coded) as_coded_terms_adjoint(predictions, target, adjoint, logits_adjoint);
  if (kind == AdversarialLoss::max_score)
    max_score_adjoint(predictions, target, adjoint.max_score, logits_adjoint);
  if (kind == AdversarialLoss::vanish)
    vanish_adjoint(predictions, target.box, adjoint.max_score, logits_adjoint);
}

/// The mean of the terms over a batch, added in double in the order of the images: iou, objectness,
/// classification, max_score, total.
template <std::floating_point T>
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

/// Adjoint of one image's terms: a share of the means' adjoint.
template <std::floating_point T>
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

template <std::floating_point T>
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
}  // namespace detail

template <std::floating_point T>
AdversarialTerms<T> adversarial(const Predictions<T>& predictions, const Target& target, AdversarialLoss kind,
                                const AdversarialWeights& weights) {
  require_predictions("adversarial", predictions);
  require_target("adversarial", predictions, target);
  detail::TermSums sums;
  if (kind == AdversarialLoss::paper) sums = detail::paper_terms(predictions, target);
  if (kind == AdversarialLoss::as_coded) sums = detail::as_coded_terms(predictions, target);
  if (kind == AdversarialLoss::max_score) sums.max_score = max_score(predictions, target);
  if (kind == AdversarialLoss::vanish) sums.max_score = vanish(predictions, target.box);
  const double total = weights.iou * sums.iou + weights.objectness * sums.objectness +
                       weights.classification * sums.classification + weights.max_score * sums.max_score;
  return {static_cast<T>(sums.iou), static_cast<T>(sums.objectness), static_cast<T>(sums.classification),
          static_cast<T>(sums.max_score), static_cast<T>(total)};
}

template <std::floating_point T>
void adversarial_adjoint(const Predictions<T>& predictions, const Target& target, AdversarialLoss kind,
                         const AdversarialWeights& weights, T total_adjoint,
                         const LogitsAdjoint<T>& logits_adjoint) {
  require_predictions("adversarial_adjoint", predictions);
  require_target("adversarial_adjoint", predictions, target);
  require_adjoint("adversarial_adjoint", predictions, logits_adjoint);
  const auto seed = static_cast<double>(total_adjoint);
  const detail::TermSums adjoint{seed * weights.iou, seed * weights.objectness, seed * weights.classification,
                                 seed * weights.max_score};
  detail::terms_adjoint(predictions, target, kind, adjoint, logits_adjoint);
}

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

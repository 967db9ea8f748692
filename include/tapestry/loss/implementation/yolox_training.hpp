#pragma once
#include <tapestry/loss/implementation/yolo_training.hpp>
#include <tapestry/loss/yolox_training.hpp>

namespace tapestry::loss {
namespace detail {
/// (y − σ(t))² · H(t, y): the cross entropy, weighted down where σ is near the wanted value.
[[nodiscard]] inline double quality_focal(double logit, double wanted) {
  const double missed = binary_cross_entropy_slope(logit, wanted);  // σ − y
  return missed * missed * binary_cross_entropy(logit, wanted);
}

[[nodiscard]] inline double quality_focal_slope(double logit, double wanted) {
  const double missed = binary_cross_entropy_slope(logit, wanted);
  return missed * (missed * missed + 2 * logistic_slope(logit) * binary_cross_entropy(logit, wanted));
}

/// Calls visit(channel, wanted, is_focal, is_objectness) for every channel of a candidate that holds a score.
/// \param match  what it has to predict; null for background
template <class Visit>
void for_each_score(const detect::Head& head, const DynamicMatch* match, Visit visit) {
  const auto objectness = head.objectness_channel();
  if (objectness) visit(*objectness, match != nullptr ? 1.0 : 0.0, false, true);
  if (match == nullptr && objectness) return;
  for (std::size_t k = 0; k < head.classes; ++k) {
    const bool is_it = match != nullptr && k == match->truth.class_index;
    visit(head.class_channel(k), is_it ? match->iou : 0.0, !objectness, false);
  }
}

/// Calls visit(candidate, match) for all candidates of an image in order, match being null for background.
template <std::floating_point T, class Visit>
void for_each_with_match(const Predictions<T>& predictions, const std::vector<DynamicMatch>& matches,
                         Visit visit) {
  auto next = matches.begin();
  for (std::size_t head = 0; head < predictions.heads.size(); ++head)
    for_each_candidate(head, predictions.heads[head], [&](const Candidate& candidate) {
      const bool is_matched = next != matches.end() && next->candidate == candidate;
      visit(candidate, is_matched ? &*next++ : nullptr);
    });
}

/// Sums of one image, not divided by anything.
template <std::floating_point T>
YoloTrainingTerms yolox_sums(const Predictions<T>& predictions, const std::vector<DynamicMatch>& matches) {
  YoloTrainingTerms sums;
  for_each_with_match(predictions, matches, [&](const Candidate& candidate, const DynamicMatch* match) {
    const auto logit = logits_of(predictions, candidate);
    if (match != nullptr) {
      const double iou = iou_with_gradient(decoded_box(predictions, candidate), match->truth.box).iou;
      sums.box += 1 - iou * iou;
    }
    for_each_score(predictions.heads[candidate.head], match,
                   [&](std::size_t channel, double wanted, bool is_focal, bool is_objectness) {
                     const double at = logit(channel);
                     double& sum = is_objectness ? sums.objectness : sums.classification;
                     sum += is_focal ? quality_focal(at, wanted) : binary_cross_entropy(at, wanted);
                   });
  });
  return sums;
}

/// \param adjoint  of the sums' weighted total
template <std::floating_point T>
void yolox_sums_adjoint(const Predictions<T>& predictions, const std::vector<DynamicMatch>& matches,
                        const YoloxTrainingOptions& options, double adjoint,
                        const LogitsAdjoint<T>& logits_adjoint) {
  for_each_with_match(predictions, matches, [&](const Candidate& candidate, const DynamicMatch* match) {
    const auto logit = logits_of(predictions, candidate);
    if (match != nullptr) {
      const Overlap overlap = iou_with_gradient(decoded_box(predictions, candidate), match->truth.box);
      detect::Box box_adjoint;
      add(box_adjoint, overlap.gradient, -2 * overlap.iou * adjoint * options.box);
      decoded_box_adjoint(predictions, candidate, box_adjoint, logits_adjoint);
    }
    for_each_score(predictions.heads[candidate.head], match,
                   [&](std::size_t channel, double wanted, bool is_focal, bool is_objectness) {
                     const double at = logit(channel);
                     const double slope =
                         is_focal ? quality_focal_slope(at, wanted) : binary_cross_entropy_slope(at, wanted);
                     const double weight = is_objectness ? options.objectness : options.classification;
                     add_to_logit(predictions, candidate, channel, adjoint * weight * slope, logits_adjoint);
                   });
  });
}

/// \throws as yolox_training()
template <std::floating_point T>
void require_matches(const char* operation, const std::vector<detect::Head>& heads,
                     const LogitsView<T>& logits, const DynamicMatches& matches, std::size_t input_height,
                     std::size_t input_width) {
  if (matches.empty()) throw DomainError({operation, ": an empty batch"});
  require_free_heads(operation, heads);
  require_predictions(operation,
                      Predictions<T>{heads, logits, matches.size() - 1, input_height, input_width});
  require_batch(operation, "matches", matches.size(), logits);
  for (std::size_t image = 0; image < matches.size(); ++image) {
    std::size_t sound = 0;
    const Predictions<T> predictions{heads, logits, image, input_height, input_width};
    for_each_with_match(predictions, matches[image],
                        [&](const Candidate& candidate, const DynamicMatch* match) {
                          if (match != nullptr && match->truth.class_index < heads[candidate.head].classes)
                            ++sound;
                        });
    if (sound < matches[image].size())
      throw DomainError({operation, ": match ", sound, " of image ", image,
                         "; expected candidates and classes of the heads, in order of head, row and column"});
  }
}

/// Divisor of the sums: candidates with a truth in all images, at least 1.
[[nodiscard]] inline double match_count(const DynamicMatches& matches) {
  std::size_t count = 0;
  for (const auto& of_image : matches) count += of_image.size();
  return static_cast<double>(std::max<std::size_t>(1, count));
}

template <std::floating_point T>
YoloTrainingVariables<T> yolox_training_of(const std::vector<detect::Head>& heads, std::size_t input_height,
                                           std::size_t input_width,
                                           const std::vector<ArrayVariable<T, 4>>& logits,
                                           const Truths& truths, const YoloxTrainingOptions& options) {
  const auto kept = std::make_shared<const KeptLogits<T>>(heads, input_height, input_width, logits);
  const auto matches = std::make_shared<const DynamicMatches>(
      dynamic_matches(kept->heads(), kept->view(), truths, input_height, input_width, options.match));
  const auto adjoint_of = [=](const YoloxTrainingOptions& weights, const LogitsAdjoint<T>& logits_adjoint) {
    yolox_training_adjoint(kept->heads(), kept->view(), *matches, input_height, input_width, weights, T(1),
                           logits_adjoint);
  };
  return record_training_terms(
      yolox_training(kept->heads(), kept->view(), *matches, input_height, input_width, options), options,
      adjoint_of, logits);
}
}  // namespace detail

template <std::floating_point T>
YoloTrainingTerms yolox_training(const std::vector<detect::Head>& heads, const LogitsView<T>& logits,
                                 const DynamicMatches& matches, std::size_t input_height,
                                 std::size_t input_width, const YoloxTrainingOptions& options) {
  detail::require_matches("yolox_training", heads, logits, matches, input_height, input_width);
  return detail::batch_terms(matches.size(), detail::match_count(matches), options, [&](std::size_t n) {
    return detail::yolox_sums(Predictions<T>{heads, logits, n, input_height, input_width}, matches[n]);
  });
}

template <std::floating_point T>
void yolox_training_adjoint(const std::vector<detect::Head>& heads, const LogitsView<T>& logits,
                            const DynamicMatches& matches, std::size_t input_height, std::size_t input_width,
                            const YoloxTrainingOptions& options, T total_adjoint,
                            const LogitsAdjoint<T>& logits_adjoint) {
  detail::require_matches("yolox_training_adjoint", heads, logits, matches, input_height, input_width);
  require_adjoint("yolox_training_adjoint", Predictions<T>{heads, logits, 0, input_height, input_width},
                  logits_adjoint);
  const double adjoint = static_cast<double>(total_adjoint) / detail::match_count(matches);
  parallel_for(matches.size(), [&](std::size_t n) {
    detail::yolox_sums_adjoint(Predictions<T>{heads, logits, n, input_height, input_width}, matches[n],
                               options, adjoint, logits_adjoint);
  });
}
}  // namespace tapestry::loss

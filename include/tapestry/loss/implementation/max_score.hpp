#pragma once
#include <algorithm>
#include <cmath>
#include <limits>
#include <tapestry/loss/max_score.hpp>
#include <tapestry/loss/responsible.hpp>

namespace tapestry::loss::detail {

template <class T>
double miss(const Predictions<T>& predictions, const Responsible& best, const Target& target) {
  const auto& head = predictions.heads[best.candidate.head];
  double unsure = nn::logistic(-class_logit(predictions, best.candidate, target.class_index));
  if (const auto objectness = head.objectness_channel())
    unsure = nn::logistic(-logit(predictions, best.candidate, *objectness)) + best.objectness * unsure;
  const double value = unsure + best.confidence * (1 - best.overlap.iou);
  return value < std::numeric_limits<double>::min() ? std::numeric_limits<double>::min()
                                                    : value;  // NaN stays
}

}  // namespace tapestry::loss::detail

namespace tapestry::loss {

template <class T>
double max_score(const Predictions<T>& predictions, const Target& target) {
  const auto best = responsible(predictions, target);
  if (!best) return 0;
  const double score = best->score();
  return score < 0.5 ? -std::log1p(-score) : -std::log(detail::miss(predictions, *best, target));
}

template <class T>
void max_score_adjoint(const Predictions<T>& predictions, const Target& target, double loss_adjoint,
                       const LogitsAdjoint<T>& logits_adjoint) {
  const auto best = responsible(predictions, target);
  if (!best) return;
  const auto& head = predictions.heads[best->candidate.head];
  const double missed = detail::miss(predictions, *best, target);
  const auto slope = [&](double at, double others) {
    return loss_adjoint * (logistic_slope(at) * others / missed);
  };
  const auto objectness = head.objectness_channel();
  if (objectness)
    add_to_logit(
        predictions, best->candidate, *objectness,
        slope(logit(predictions, best->candidate, *objectness), best->class_probability * best->overlap.iou),
        logits_adjoint);
  class_logit_adjoint(predictions, best->candidate, target.class_index,
                      slope(class_logit(predictions, best->candidate, target.class_index),
                            (objectness ? best->objectness : 1) * best->overlap.iou),
                      logits_adjoint);
  detect::Box box_adjoint{0, 0, 0, 0};
  const double scale = best->confidence / std::max(missed, std::numeric_limits<double>::epsilon() / 2);
  detail::add(box_adjoint, best->overlap.gradient, loss_adjoint * scale);
  decoded_box_adjoint(predictions, best->candidate, box_adjoint, logits_adjoint);
}

}  // namespace tapestry::loss

namespace tapestry::loss::detail {

template decltype(miss<float>) miss<float>;
template decltype(miss<double>) miss<double>;

}  // namespace tapestry::loss::detail

namespace tapestry::loss {

template decltype(max_score<float>) max_score<float>;
template decltype(max_score<double>) max_score<double>;
template decltype(max_score_adjoint<float>) max_score_adjoint<float>;
template decltype(max_score_adjoint<double>) max_score_adjoint<double>;

}  // namespace tapestry::loss

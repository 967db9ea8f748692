#pragma once
#include <tapestry/loss/detail/adversarial_terms.hpp>

namespace tapestry::loss {
namespace detail {
/// One axis of two overlapping boxes: lengths of intersection and hull, and how the box's own centre and
/// extent move them. Where two edges coincide, the mean of the two one-sided derivatives is taken, so that
/// a box that equals the target has derivative 0.
struct AxisOverlap {
  double shared = 0, hull = 0;
  double shared_by_centre = 0, shared_by_extent = 0;
  double hull_by_centre = 0, hull_by_extent = 0;

  AxisOverlap(double centre, double extent, double target_centre, double target_extent) {
    const double low = centre - extent / 2, high = centre + extent / 2;
    const double target_low = target_centre - target_extent / 2,
                 target_high = target_centre + target_extent / 2;
    shared = std::min(high, target_high) - std::max(low, target_low);
    hull = std::max(high, target_high) - std::min(low, target_low);
    const double high_is_inner = high < target_high ? 1 : (high == target_high ? 0.5 : 0);
    const double low_is_inner = low > target_low ? 1 : (low == target_low ? 0.5 : 0);
    shared_by_centre = high_is_inner - low_is_inner;
    shared_by_extent = (high_is_inner + low_is_inner) / 2;
    hull_by_centre = low_is_inner - high_is_inner;
    hull_by_extent = (2 - high_is_inner - low_is_inner) / 2;
  }
};

[[nodiscard]] inline bool has_nan(const detect::Box& box) {
  return std::isnan(box.cx) || std::isnan(box.cy) || std::isnan(box.w) || std::isnan(box.h);
}

/// True when both boxes have an area and the area of the larger can be represented.
[[nodiscard]] inline bool is_measurable(const detect::Box& box, const detect::Box& target) {
  return box.w > 0 && box.h > 0 && target.w > 0 && target.h > 0 && std::isfinite(box.cx) &&
         std::isfinite(box.cy) && std::isfinite(box.w * box.w + box.h * box.h + target.w * target.h);
}

template <std::floating_point T>
double miss(const Predictions<T>& predictions, const Responsible& best, const Target& target) {
  const auto& head = predictions.heads[best.candidate.head];
  double unsure = nn::logistic(-class_logit(predictions, best.candidate, target.class_index));
  if (const auto objectness = head.objectness_channel())
    unsure = nn::logistic(-logit(predictions, best.candidate, *objectness)) + best.objectness * unsure;
  const double value = unsure + best.confidence * (1 - best.overlap.iou);
  return value < std::numeric_limits<double>::min() ? std::numeric_limits<double>::min()
                                                    : value;  // NaN stays
}

/// max_score() of the candidate that finds the target best.
template <std::floating_point T>
double score_loss(const Predictions<T>& predictions, const std::optional<Responsible>& best,
                  const Target& target) {
  if (!best) return 0;
  const double score = best->score();
  return score < 0.5 ? -std::log1p(-score) : -std::log(miss(predictions, *best, target));
}

/// Adds loss_adjoint times the derivative of score_loss().
template <std::floating_point T>
void score_loss_adjoint(const Predictions<T>& predictions, const std::optional<Responsible>& best,
                        const Target& target, double loss_adjoint, const LogitsAdjoint<T>& logits_adjoint) {
  if (!best) return;
  const auto& head = predictions.heads[best->candidate.head];
  const double missed = miss(predictions, *best, target);
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
  add(box_adjoint, best->overlap.gradient, loss_adjoint * scale);
  decoded_box_adjoint(predictions, best->candidate, box_adjoint, logits_adjoint);
}

/// The best candidate for a class, and max_score() of it.
struct BestOfClass {
  std::optional<Responsible> best;
  double loss;
};

/// One for every class that all heads have.
template <std::floating_point T>
std::vector<BestOfClass> best_of_each_class(const Predictions<T>& predictions, const detect::Box& box) {
  std::size_t classes = predictions.heads.empty() ? 0 : predictions.heads.front().classes;
  for (const auto& head : predictions.heads) classes = std::min(classes, head.classes);
  std::vector<BestOfClass> all(classes);
  for (std::size_t k = 0; k < classes; ++k) {
    all[k].best = responsible(predictions, {k, box});
    all[k].loss = score_loss(predictions, all[k].best, {k, box});
  }
  return all;
}

/// log(1 + Σ (e^l − 1)) of the classes' losses l, which neither overflows nor cancels.
[[nodiscard]] inline double log_of_odds(const std::vector<BestOfClass>& classes) {
  double largest = 0, sum = 0;
  for (const auto& [best, loss] : classes) largest = loss > largest || std::isnan(loss) ? loss : largest;
  if (!(largest > 1)) {
    for (const auto& [best, loss] : classes) sum += std::expm1(loss);
    return std::log1p(sum);
  }
  for (const auto& [best, loss] : classes) sum += std::exp(loss - largest) - std::exp(-largest);
  return largest + std::log(sum + std::exp(-largest));
}
}  // namespace detail

template <std::floating_point T>
double max_score(const Predictions<T>& predictions, const Target& target) {
  return detail::score_loss(predictions, responsible(predictions, target), target);
}

template <std::floating_point T>
void max_score_adjoint(const Predictions<T>& predictions, const Target& target, double loss_adjoint,
                       const LogitsAdjoint<T>& logits_adjoint) {
  detail::score_loss_adjoint(predictions, responsible(predictions, target), target, loss_adjoint,
                             logits_adjoint);
}

template <std::floating_point T>
double vanish(const Predictions<T>& predictions, const detect::Box& box) {
  return detail::log_of_odds(detail::best_of_each_class(predictions, box));
}

template <std::floating_point T>
void vanish_adjoint(const Predictions<T>& predictions, const detect::Box& box, double loss_adjoint,
                    const LogitsAdjoint<T>& logits_adjoint) {
  const auto classes = detail::best_of_each_class(predictions, box);
  const double together = detail::log_of_odds(classes);
  for (std::size_t k = 0; k < classes.size(); ++k)
    if (classes[k].loss != 0)
      detail::score_loss_adjoint(predictions, classes[k].best, {k, box},
                                 loss_adjoint * std::exp(classes[k].loss - together), logits_adjoint);
}
}  // namespace tapestry::loss

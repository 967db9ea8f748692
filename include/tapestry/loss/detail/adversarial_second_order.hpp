#pragma once
#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/loss/detail/adversarial_kinds.hpp>
#include <tapestry/loss/detail/responsible.hpp>

namespace tapestry::loss::detail {
/// A candidate of one image as formulas of its logits, on a tape of duals.
template <DualNumber D>
class TapedCandidate {
  using T = typename D::value_type;
  using S = Variable<D>;

 public:
  TapedCandidate(const Predictions<T>& predictions, const Candidate& candidate,
                 const std::vector<ArrayVariable<D, 4>>& logits)
      : head_(predictions.heads[candidate.head]),
        logits_(logits[candidate.head]),
        place_(place_of(predictions, candidate)),
        first_{predictions.image, candidate.anchor * head_.candidate_channel_count(), candidate.row,
               candidate.column} {}

  [[nodiscard]] S logit(std::size_t channel) const {
    return element(logits_, {first_[0], first_[1] + channel, first_[2], first_[3]});
  }
  /// The formula of detect::class_logit().
  [[nodiscard]] S class_logit(std::size_t k) const {
    std::vector<S> others;
    for (std::size_t j = 0; head_.exclusive_classes && j < head_.classes; ++j)
      if (j != k) others.push_back(logit(head_.class_channel(j)));
    const S own = logit(head_.class_channel(k));
    return head_.exclusive_classes ? S(own - logsumexp(others)) : own;
  }
  /// IoU of its box and the target's, as of iou_with_gradient().
  [[nodiscard]] S iou(const detect::Box& target) const {
    const auto [cx, cy, w, h] = box();
    const S across = shared(cx, w, target.cx, target.w), down = shared(cy, h, target.cy, target.h);
    if (!(w.value() > D(0) && h.value() > D(0) && across.value() > D(0) && down.value() > D(0))) return S(0);
    const S inner = across * down;
    return inner / (w * h + static_cast<T>(target.w * target.h) - inner);
  }

 private:
  /// The formula of detect::decode_box().
  [[nodiscard]] std::array<S, 4> box() const {
    const auto [x, y] = detect::detail::axes_of(head_, place_);
    const auto number = [](double value) { return static_cast<T>(value); };
    if (head_.decode == detect::DecodeFamily::distance) {
      std::array<S, 4> reach;
      for (std::size_t side = 0; side < 4; ++side) reach[side] = mean_bin(side);
      const auto& [left, top, right, bottom] = reach;
      return {number(x.position(1)) * ((right - left) / T(2) + number(x.cell + 0.5)),
              number(y.position(1)) * ((bottom - top) / T(2) + number(y.cell + 0.5)),
              number(x.length(1)) * (left + right), number(y.length(1)) * (top + bottom)};
    }
    const S cx = logit(x_channel), cy = logit(y_channel), w = logit(w_channel), h = logit(h_channel);
    if (head_.decode == detect::DecodeFamily::decoded) return {cx, cy, w, h};
    return {number(x.position(1)) * (offset(cx) + number(x.cell)),
            number(y.position(1)) * (offset(cy) + number(y.cell)), number(x.unit) * factor(w),
            number(y.unit) * factor(h)};
  }
  /// The formula of detect::centre_offset().
  [[nodiscard]] S offset(const S& at) const {
    if (head_.decode == detect::DecodeFamily::yolox) return at;
    if (head_.decode == detect::DecodeFamily::ultralytics) return T(2) * sigmoid(at) - T(0.5);
    return (sigmoid(at) - T(0.5)) * static_cast<T>(head_.scale_x_y) + T(0.5);
  }
  /// The formula of detect::extent_factor().
  [[nodiscard]] S factor(const S& at) const {
    if (head_.decode == detect::DecodeFamily::ultralytics) return T(4) * square(sigmoid(at));
    return exp(at.value() > D(T(detect::largest_extent_logit)) ? S(T(detect::largest_extent_logit)) : at);
  }
  [[nodiscard]] S mean_bin(std::size_t side) const {
    std::vector<S> bins;
    for (std::size_t bin = 0; bin < head_.bins; ++bin)
      bins.push_back(logit(head_.box_channel() + side * head_.bins + bin));
    const S together = logsumexp(bins);
    S mean = 0;
    for (std::size_t bin = 1; bin < bins.size(); ++bin)
      mean = mean + static_cast<T>(bin) * exp(bins[bin] - together);
    return mean;
  }
  /// Length that an extent around a centre shares with the target's; below 0 if they do not meet.
  [[nodiscard]] static S shared(const S& centre, const S& extent, double target, double target_extent) {
    const S high = min(centre + extent / T(2), static_cast<T>(target + target_extent / 2));
    return high - max(centre - extent / T(2), static_cast<T>(target - target_extent / 2));
  }

  const detect::Head& head_;
  const ArrayVariable<D, 4>& logits_;
  detect::CandidatePlace place_;
  Extents<4> first_;
};

/// The terms of one image on a tape of duals: candidates are chosen by the values of their logits, and
/// written as formulas.
template <DualNumber D>
struct TapedTerms {
  using T = typename D::value_type;
  using S = Variable<D>;

  const Predictions<T>& predictions;
  const std::vector<ArrayVariable<D, 4>>& logits;

  void add_paper(const Target& target, AdversarialTerms<S>& sums) const {
    for (std::size_t head = 0; head < predictions.heads.size(); ++head) {
      const auto found = responsible(predictions, head, target);
      if (!found) continue;
      const TapedCandidate<D> of(predictions, found->candidate, logits);
      const auto objectness = predictions.heads[head].objectness_channel();
      const S of_class = of.class_logit(target.class_index);
      sums.iou = sums.iou + of.iou(target.box);
      sums.objectness =
          sums.objectness +
          sigmoid(objectness ? of.logit(*objectness)
                             : of.logit(objectness_channel(predictions.heads[head], target.class_index)));
      sums.classification = sums.classification + sigmoid(of_class);
    }
  }

  /// −log(1 − score) of the best candidate, as max_score().
  [[nodiscard]] S score_loss(const Target& target) const {
    const auto best = responsible(predictions, target);
    if (!best) return 0;
    const TapedCandidate<D> of(predictions, best->candidate, logits);
    const auto objectness = predictions.heads[best->candidate.head].objectness_channel();
    const S of_class = of.class_logit(target.class_index), iou = of.iou(target.box);
    S sure = sigmoid(of_class), unsure = sigmoid(-of_class);
    if (objectness) {
      const S of_object = of.logit(*objectness);
      unsure = sigmoid(-of_object) + sigmoid(of_object) * unsure;
      sure = sigmoid(of_object) * sure;
    }
    if (best->score() < 0.5) return -log1p(-(sure * iou));
    return -log(unsure + sure * (T(1) - iou));
  }

  /// log(1 + Σ (e^l − 1)) of the losses l of every class, as vanish().
  [[nodiscard]] S vanish(const detect::Box& box) const {
    std::vector<S> exponents{S(0)};
    std::size_t classes = predictions.heads.front().classes;
    for (const auto& head : predictions.heads) classes = std::min(classes, head.classes);
    for (std::size_t k = 0; k < classes; ++k) {
      const S loss = score_loss({k, box});
      if (loss.value() > D(0)) exponents.push_back(log(expm1(loss)));
    }
    return logsumexp(exponents);
  }
};

/// adversarial() on a tape of duals. \throws DomainError for as_coded, which has no second order here
template <DualNumber D>
[[nodiscard]] AdversarialTerms<Variable<D>> adversarial_of_duals(
    const std::vector<detect::Head>& heads, std::size_t input_height, std::size_t input_width,
    const std::vector<ArrayVariable<D, 4>>& logits, std::span<const Target> targets, AdversarialLoss kind,
    const AdversarialWeights& weights) {
  using T = typename D::value_type;
  if (kind == AdversarialLoss::as_coded)
    throw DomainError("adversarial: the second order of as_coded is not known; take paper or max_score");
  std::vector<Array<T, 4>> values;
  for (const auto& head : logits) values.push_back(tapestry::detail::part_of(head.value(), 0));
  const auto view = to_read(values);
  require_batch("adversarial", "targets", targets.size(), view);
  AdversarialTerms<Variable<D>> mean;
  for (std::size_t n = 0; n < targets.size(); ++n) {
    const Predictions<T> predictions{heads, view, n, input_height, input_width};
    require_predictions("adversarial", predictions);
    require_target("adversarial", predictions, targets[n]);
    const TapedTerms<D> terms{predictions, logits};
    if (kind == AdversarialLoss::paper) terms.add_paper(targets[n], mean);
    if (kind == AdversarialLoss::max_score) mean.max_score = mean.max_score + terms.score_loss(targets[n]);
    if (kind == AdversarialLoss::vanish) mean.max_score = mean.max_score + terms.vanish(targets[n].box);
  }
  for (auto* const term : {&mean.iou, &mean.objectness, &mean.classification, &mean.max_score})
    *term = *term / static_cast<T>(targets.size());
  mean.total = static_cast<T>(weights.iou) * mean.iou + static_cast<T>(weights.objectness) * mean.objectness +
               static_cast<T>(weights.classification) * mean.classification +
               static_cast<T>(weights.max_score) * mean.max_score;
  return mean;
}
}  // namespace tapestry::loss::detail

#pragma once
#include <tapestry/loss/detail/responsible.hpp>

namespace tapestry::loss {
/// Weight of each head in the objectness term of the Ultralytics kind, by fineness of the grid: 4, 1, 0.4
/// from the finest for three heads; 4, 1, 0.25, 0.06, 0.02 for any other number (0.02 beyond the fifth).
[[nodiscard]] inline std::vector<double> objectness_balance(const std::vector<detect::Head>& heads) {
  constexpr std::array<double, 3> three{4.0, 1.0, 0.4};
  constexpr std::array<double, 5> other{4.0, 1.0, 0.25, 0.06, 0.02};
  std::vector<double> balance;
  for (const auto& head : heads) {
    const auto is_finer = [&](const detect::Head& peer) {
      return peer.grid_height * peer.grid_width > head.grid_height * head.grid_width;
    };
    const auto rank = static_cast<std::size_t>(std::count_if(heads.begin(), heads.end(), is_finer));
    balance.push_back(heads.size() == 3 ? three[rank] : other[std::min<std::size_t>(rank, 4)]);
  }
  return balance;
}

/// Mean over all candidates of one head of the cross entropy between its objectness logit and 1 where the
/// candidate is matched, 0 elsewhere. Minimising it RAISES objectness at the target. A head without
/// objectness has the logit of the target's class in its place.
///
/// \param matched      candidates of this head
/// \param class_index  of the target
template <std::floating_point T>
[[nodiscard]] double mean_objectness_entropy(const Predictions<T>& predictions, std::size_t head_index,
                                             const std::vector<Candidate>& matched, std::size_t class_index) {
  const auto& head = predictions.heads[head_index];
  const std::size_t channel = objectness_channel(head, class_index);
  double sum = 0;
  for_each_candidate(head_index, head, [&](const Candidate& candidate) {
    sum += binary_cross_entropy(logit(predictions, candidate, channel), 0);
  });
  for (const Candidate& candidate : matched) sum -= logit(predictions, candidate, channel);
  return sum / static_cast<double>(head.candidate_count());
}

/// Adds loss_adjoint times the derivative of mean_objectness_entropy().
template <std::floating_point T>
void mean_objectness_entropy_adjoint(const Predictions<T>& predictions, std::size_t head_index,
                                     const std::vector<Candidate>& matched, std::size_t class_index,
                                     double loss_adjoint, const LogitsAdjoint<T>& logits_adjoint) {
  const auto& head = predictions.heads[head_index];
  const std::size_t channel = objectness_channel(head, class_index);
  const double scale = loss_adjoint / static_cast<double>(head.candidate_count());
  for_each_candidate(head_index, head, [&](const Candidate& candidate) {
    const bool is_matched = std::find(matched.begin(), matched.end(), candidate) != matched.end();
    const double slope =
        binary_cross_entropy_slope(logit(predictions, candidate, channel), is_matched ? 1 : 0);
    add_to_logit(predictions, candidate, channel, scale * slope, logits_adjoint);
  });
}

/// Largest over the classes k of the mean over the matched candidates of (raw logit of k, where k is the
/// target's class, else 0). With two classes or more that is max(0, mean logit of the target's class); with
/// one class the mean itself; with no match 0. The logit is not a probability, and the other classes do not
/// matter, as in FCA's published program. Its derivative at mean 0 is taken as 0.
template <std::floating_point T>
[[nodiscard]] double largest_mean_logit(const Predictions<T>& predictions,
                                        const std::vector<Candidate>& matched, std::size_t class_index) {
  if (matched.empty()) return 0;
  const auto& head = predictions.heads[matched.front().head];
  double sum = 0;
  for (const Candidate& candidate : matched)
    sum += logit(predictions, candidate, head.class_channel(class_index));
  const double mean = sum / static_cast<double>(matched.size());
  const bool has_other_classes = head.classes > 1;
  return has_other_classes && mean <= 0 ? 0 : mean;  // NaN stays NaN
}

/// Adds loss_adjoint times the derivative of largest_mean_logit().
template <std::floating_point T>
void largest_mean_logit_adjoint(const Predictions<T>& predictions, const std::vector<Candidate>& matched,
                                std::size_t class_index, double loss_adjoint,
                                const LogitsAdjoint<T>& logits_adjoint) {
  if (matched.empty()) return;
  const auto& head = predictions.heads[matched.front().head];
  const bool has_other_classes = head.classes > 1;
  if (has_other_classes && largest_mean_logit(predictions, matched, class_index) == 0) return;
  const double slope = loss_adjoint / static_cast<double>(matched.size());
  for (const Candidate& candidate : matched)
    add_to_logit(predictions, candidate, head.class_channel(class_index), slope, logits_adjoint);
}

namespace detail {
/// 1 − o·p·u as (1 − o) + o·(1 − p) + o·p·(1 − u), which keeps its digits when all three are near 1; for a
/// head without objectness 1 − p·u as (1 − p) + p·(1 − u). At least the smallest normal number, so that the
/// loss stays below 709.
template <std::floating_point T>
[[nodiscard]] double miss(const Predictions<T>& predictions, const Responsible& best, const Target& target);
}  // namespace detail

/// −log(1 − m), m being the largest σ(obj) · p(class) · IoU(box, target) of all candidates of all heads,
/// without σ(obj) for heads that have none; 0 when no box overlaps the target. Its gradient grows as the
/// target is found more surely, where the gradient of a probability vanishes.
///
/// Kinks: it differentiates the first candidate that attains the maximum; IoU's as in iou_with_gradient().
/// Stays finite for logits of any size. NaN logits give NaN. Source: Zhou et al., RAUCA (ICML 2024), eq. 9,
/// there with complete IoU, which can be negative.
template <std::floating_point T>
[[nodiscard]] double max_score(const Predictions<T>& predictions, const Target& target);

/// Adds loss_adjoint times the derivative of max_score().
///
/// The derivative by the box is o·p/(1 − m) · ∂IoU. IoU is only accurate to 2⁻⁵³: 1 − m
/// is taken as at least that.
template <std::floating_point T>
void max_score_adjoint(const Predictions<T>& predictions, const Target& target, double loss_adjoint,
                       const LogitsAdjoint<T>& logits_adjoint);

/// Loss that is 0 only if no box of any class is found over the target: a soft maximum of max_score()
/// over all classes k,
///
///     log(1 + Σ_k m_k / (1 − m_k)),   m_k = 1 − e^(−max_score of class k),
///
/// the log of one plus the odds of every name. For one class it is max_score(); class k takes the share (m_k
/// / (1 − m_k)) / (1 + Σ) of the gradient, so that no other class replaces the first. Kinks and NaN as
/// max_score(). \param box of the target, pixels of the input
template <std::floating_point T>
[[nodiscard]] double vanish(const Predictions<T>& predictions, const detect::Box& box);

/// Adds loss_adjoint times the derivative of vanish().
template <std::floating_point T>
void vanish_adjoint(const Predictions<T>& predictions, const detect::Box& box, double loss_adjoint,
                    const LogitsAdjoint<T>& logits_adjoint);
}  // namespace tapestry::loss

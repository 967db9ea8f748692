#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <tapestry/loss/prediction.hpp>
#include <vector>

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
template <class T>
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
template <class T>
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

}  // namespace tapestry::loss

#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <numeric>
#include <span>
#include <string>
#include <tapestry/core/error.hpp>
#include <vector>

namespace tapestry::camouflage {

/// How much each view of a minibatch counts when only the worst share of them does: the weights, which add up
/// to one, under which the sum of the losses is their conditional value at risk,
///
///   CVaR = Σ w[i]·L[i] = min over z of  z + 1/(share·n) · Σ max(0, L[i] − z).
///
/// The views of the largest losses count 1/(share·n) each, the last of them what is left; of equal losses the
/// earlier one counts first. A share of 1 is the mean, one of at most 1/n the largest loss alone. The
/// gradient of the sum with the weights held is that of CVaR where no two losses at its edge are equal, and a
/// subgradient there. Source: Rockafellar and Uryasev, "Optimization of conditional value-at-risk" (J. Risk
/// 2, 2000), eq. 4 and 9.
///
/// \param losses  L, at least one, none NaN
/// \param share   above 0, at most 1
/// \throws DomainError for a share or losses that are none
[[nodiscard]] inline std::vector<double> worst_view_weights(std::span<const double> losses, double share) {
  if (!(share > 0 && share <= 1))
    throw DomainError("worst_view_weights: the share is " + std::to_string(share) +
                      ", expected above 0 and at most 1");
  if (losses.empty()) throw DomainError("worst_view_weights: no losses");
  if (std::ranges::any_of(losses, [](double loss) { return std::isnan(loss); }))
    throw DomainError("worst_view_weights: a loss is not a number");
  std::vector<std::size_t> order(losses.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, [&](std::size_t a, std::size_t b) { return losses[a] > losses[b]; });
  const double counted = std::max(1.0, share * static_cast<double>(losses.size()));
  std::vector<double> weights(losses.size(), 0.0);
  double left = counted;
  for (const std::size_t i : order) {
    if (!(left > 0)) break;
    weights[i] = std::min(1.0, left) / counted;
    left -= 1;
  }
  return weights;
}

}  // namespace tapestry::camouflage

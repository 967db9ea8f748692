#pragma once
#include <span>
#include <tapestry/core/compiled.hpp>
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
[[nodiscard]] std::vector<double> worst_view_weights(std::span<const double> losses, double share);

}  // namespace tapestry::camouflage

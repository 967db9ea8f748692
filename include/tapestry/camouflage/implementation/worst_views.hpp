#pragma once
#include <tapestry/camouflage/objective_terms.hpp>

namespace tapestry::camouflage {
std::vector<double> worst_view_weights(std::span<const double> losses, double share) {
  if (!(share > 0 && share <= 1))
    throw DomainError({"worst_view_weights: the share is ", share, ", expected above 0 and at most 1"});
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

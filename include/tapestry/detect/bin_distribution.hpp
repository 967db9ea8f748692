#pragma once
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <tapestry/detect/head.hpp>  // largest_bin_count

namespace tapestry::detect {

/// softmax of the logits of B bins, which says how far a side of a box is from its cell's centre: bin b
/// stands for b cells. Finite for finite logits of any size; a NaN among them makes everything NaN. Source:
/// Li et al., "Generalized Focal Loss" (NeurIPS 2020), the general distribution of a box.
class BinDistribution {
 public:
  /// \param count  B, 1 to largest_bin_count
  /// \param logit  takes a bin and returns its logit as a double
  template <std::invocable<std::size_t> Logits>
  BinDistribution(std::size_t count, Logits logit) : count_(count) {
    for (std::size_t bin = 0; bin < count; ++bin) shares_[bin] = logit(bin);
    double largest = shares_[0];
    for (std::size_t bin = 1; bin < count; ++bin)
      if (shares_[bin] > largest) largest = shares_[bin];
    double sum = 0;
    for (std::size_t bin = 0; bin < count; ++bin) sum += shares_[bin] = std::exp(shares_[bin] - largest);
    for (std::size_t bin = 0; bin < count; ++bin) shares_[bin] /= sum;
  }

  /// d = Σ_b b·p_b, in cells.
  [[nodiscard]] double mean() const {
    double sum = 0;
    for (std::size_t bin = 0; bin < count_; ++bin) sum += static_cast<double>(bin) * shares_[bin];
    return sum;
  }

  /// ∂d/∂logit_b = p_b·(b − d), as p_b·Σ_j p_j·(b − j): where p_b is almost 1, b − d would lose its digits.
  [[nodiscard]] double mean_slope(std::size_t bin) const {
    double sum = 0;
    for (std::size_t other = 0; other < count_; ++other)
      sum += shares_[other] * (static_cast<double>(bin) - static_cast<double>(other));
    return shares_[bin] * sum;
  }

 private:
  std::size_t count_;
  std::array<double, largest_bin_count> shares_;  ///< p; those beyond count_ are not set
};

}  // namespace tapestry::detect

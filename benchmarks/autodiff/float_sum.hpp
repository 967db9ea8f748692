#pragma once
#include <algorithm>
#include "seeded.hpp"

namespace tapestry::benchmarks {
/// The sum of 4 million numbers in [0, 1) that are floats: what accumulation costs, and what it loses. The
/// error is that of the value; all derivatives are 1.
struct FloatSum {
  static constexpr const char* name = "float-sum";
  static constexpr std::size_t terms = 4000000;
  [[nodiscard]] static std::vector<double> start() {
    auto x = uniform(terms, 0, 1, 81);
    for (double& entry : x) entry = static_cast<double>(static_cast<float>(entry));
    return x;
  }

  template <class S>
  [[nodiscard]] S operator()(const S* x) const {
    S total = 0;
    for (std::size_t i = 0; i < terms; ++i) total += x[i];
    return total;
  }
};

template <class T>
T hand_adjoint(const FloatSum& sum, const T* x, T* gradient) {
  std::fill_n(gradient, FloatSum::terms, T(1));
  return sum(x);
}
}  // namespace tapestry::benchmarks

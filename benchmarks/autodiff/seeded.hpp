#pragma once
#include <cmath>
#include <cstddef>
#include <random>
#include <vector>

namespace tapestry::benchmarks {
// The functions that objectives call, of numbers as of tapes' scalars.
using std::atan, std::cos, std::exp, std::log, std::sin, std::sqrt, std::tanh;

[[nodiscard]] inline std::vector<double> uniform(std::size_t count, double low, double high, unsigned seed) {
  std::mt19937_64 generator(seed);
  std::uniform_real_distribution<double> distribution(low, high);
  std::vector<double> values(count);
  for (double& value : values) value = distribution(generator);
  return values;
}

template <class S>
[[nodiscard]] S larger(const S& a, const S& b) {
  return a > b ? a : b;
}
template <class S>
[[nodiscard]] S smaller(const S& a, const S& b) {
  return a < b ? a : b;
}
}  // namespace tapestry::benchmarks

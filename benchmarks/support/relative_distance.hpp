#pragma once
#include <cmath>
#include <tapestry/core/error.hpp>
#include <vector>

namespace tapestry::benchmarks {
/// ‖found − expected‖ / ‖expected‖; ‖found‖ where 0 is expected.
template <std::floating_point T>
[[nodiscard]] double relative_distance(const std::vector<T>& found, const std::vector<double>& expected) {
  if (found.size() != expected.size()) {
    throw Error(ErrorKind::mismatch,
                std::to_string(found.size()) + " numbers instead of " + std::to_string(expected.size()));
  }
  double difference = 0, norm = 0;
  for (std::size_t i = 0; i < found.size(); ++i) {
    const double d = static_cast<double>(found[i]) - expected[i];
    difference += d * d;
    norm += expected[i] * expected[i];
  }
  return std::sqrt(norm == 0 ? difference : difference / norm);
}
}  // namespace tapestry::benchmarks

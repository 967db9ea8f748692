#pragma once
#include <cmath>
#include <cstddef>

namespace tapestry::test {
/// ‖a − b‖ / ‖b‖ of `count` numbers, in double; 0 where both are 0.
template <class A, class B>
double relative_distance(const A* a, const B* b, std::size_t count) {
  double difference = 0;
  double norm = 0;
  for (std::size_t i = 0; i < count; ++i) {
    const double d = static_cast<double>(a[i]) - static_cast<double>(b[i]);
    difference += d * d;
    norm += static_cast<double>(b[i]) * static_cast<double>(b[i]);
  }
  return difference == 0 ? 0 : std::sqrt(difference / norm);
}

/// The same of two arrays of one shape.
template <class A, class B>
double relative_distance(const A& a, const B& b) {
  return relative_distance(a.data(), b.data(), b.size());
}
}  // namespace tapestry::test

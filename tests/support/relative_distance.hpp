#pragma once
#include <cmath>
#include <cstddef>
#include "catch.hpp"

namespace tapestry::test {
/// ‖a − b‖ / ‖b‖ of `count` numbers, in double; 0 where both are 0.
template <class A, class B>
double relative_distance(const A* a, const B* b, std::size_t count) {
  double difference = 0, norm = 0;
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

/// Largest |a − b| of two arrays of one size, in double; NaN if a difference is NaN.
template <class A, class B>
double largest_difference(const A& a, const B& b) {
  REQUIRE(a.size() == b.size());
  double largest = 0;
  for (std::size_t i = 0; i < b.size(); ++i) {
    const double difference = std::abs(static_cast<double>(a.data()[i]) - static_cast<double>(b.data()[i]));
    if (!(difference <= largest)) largest = difference;
  }
  return largest;
}
}  // namespace tapestry::test

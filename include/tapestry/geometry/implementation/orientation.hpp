#pragma once
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <tapestry/geometry/orientation.hpp>

namespace tapestry::geometry::detail {

/// A sum of doubles without rounding: no two of its terms overlap, the largest comes last.
/// Source: Shewchuk, Adaptive Precision Floating-Point Arithmetic and Fast Robust Geometric Predicates
/// (1997), theorem 10 (adding one double) and theorem 18 (a product as two doubles).
class ExactSum {
 public:
  void add_product(double a, double b) {
    const double product = a * b;
    add(std::fma(a, b, -product));
    add(product);
  }

  /// −1, 0 or 1
  [[nodiscard]] int sign() const {
    for (std::size_t i = count_; i-- > 0;)
      if (terms_[i] != 0) return terms_[i] > 0 ? 1 : -1;
    return 0;
  }

 private:
  void add(double value) {
    for (std::size_t i = 0; i < count_; ++i) {
      const double sum = value + terms_[i];
      const double part = sum - value;
      terms_[i] = (value - (sum - part)) + (terms_[i] - part);
      value = sum;
    }
    terms_.at(count_++) = value;
  }

  std::array<double, 12> terms_{};  // of the six products of three points
  std::size_t count_ = 0;
};

}  // namespace tapestry::geometry::detail

namespace tapestry::geometry {

int orientation(const Vector2& a, const Vector2& b, const Vector2& c) {
  constexpr double unit = std::numeric_limits<double>::epsilon() / 2;
  const double left = (a[0] - c[0]) * (b[1] - c[1]);
  const double right = (a[1] - c[1]) * (b[0] - c[0]);
  const double bound = (3 + 16 * unit) * unit * (std::abs(left) + std::abs(right));
  if (left - right > bound) return 1;
  if (left - right < -bound) return -1;
  detail::ExactSum sum;
  for (const auto* const edge : {&a, &b, &c}) {
    const Vector2& next = edge == &a ? b : edge == &b ? c : a;
    sum.add_product((*edge)[0], next[1]);
    sum.add_product(-(*edge)[1], next[0]);
  }
  return sum.sign();
}

}  // namespace tapestry::geometry

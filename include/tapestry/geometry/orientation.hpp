#pragma once
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>

namespace tapestry::geometry {

/// A point of a plane.
using Vector2 = std::array<double, 2>;

namespace detail {
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
}  // namespace detail

/// Whether a, b, c turn to the left (1), to the right (−1) or lie on one line (0): the sign of
///
///   (b − a) × (c − a) = aₓb_y − a_ybₓ + bₓc_y − b_ycₓ + cₓa_y − c_yaₓ
///
/// without rounding, as long as no product leaves the range of normal doubles (coordinates that are 0 or from
/// 1e-130 to 1e130 are safe). Where rounding cannot change the sign, it costs two products.
/// Source of the bound: Shewchuk (1997), figure 21.
///
/// \param a,b,c  points of a plane, any unit
[[nodiscard]] inline int orientation(const Vector2& a, const Vector2& b, const Vector2& c) {
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

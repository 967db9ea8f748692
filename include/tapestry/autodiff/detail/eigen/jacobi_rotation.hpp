#pragma once
#include <tapestry/autodiff/detail/eigen/triangular_solve.hpp>

namespace Eigen {
template <class Scalar>
class JacobiRotation;

/// Rotation [c s; −s c] of variables, as Eigen's own. Eigen's rotation drops derivatives of an entry 0.
template <tapestry::Differentiable S>
class JacobiRotation<S> {
 public:
  using RealScalar = S;

  JacobiRotation() = default;
  JacobiRotation(const S& c, const S& s) : c_(c), s_(s) {}

  S& c() { return c_; }
  S& s() { return s_; }
  [[nodiscard]] S s() const { return s_; }
  /// The cosine. Matrices leave out a rotation by (1, 0); one that has derivatives has the number before 1.
  [[nodiscard]] S c() const {
    using B = decltype(tapestry::detail::base_value(c_));
    const bool is_one = c_ == B(1) && s_ == B(0);
    if (!is_one || (tapestry::detail::is_passive_zero(s_) && tapestry::detail::is_passive_zero(S(c_ - B(1)))))
      return c_;
    return c_ - std::numeric_limits<B>::epsilon() / 2;
  }

  [[nodiscard]] JacobiRotation operator*(const JacobiRotation& other) const {
    return {c_ * other.c_ - s_ * other.s_, c_ * other.s_ + s_ * other.c_};
  }
  [[nodiscard]] JacobiRotation transpose() const { return {c_, -s_}; }
  [[nodiscard]] JacobiRotation adjoint() const { return transpose(); }

  /// Makes the J for which Jᵀ [x y; y z] J is diagonal.
  /// \returns whether y is not 0
  bool makeJacobi(const S& x, const S& y, const S& z) {
    const S gap = x - z, width = hypot(gap, S(2.0 * y));
    const S tangent = width == 0 ? S(0) : S(2.0 * y / (gap > 0 ? S(gap + width) : S(gap - width)));
    c_ = 1.0 / sqrt(1.0 + tangent * tangent);
    s_ = -tangent * c_;
    return y != 0;
  }
  template <class Matrix>
  bool makeJacobi(const MatrixBase<Matrix>& a, Index p, Index q) {
    return makeJacobi(a.coeff(p, p), a.coeff(p, q), a.coeff(q, q));
  }

  /// Makes the J for which Jᵀ (p, q) is (r, 0).
  void makeGivens(const S& p, const S& q, S* r = nullptr) {
    const bool is_flat = abs(p) > abs(q);
    if (p == 0 && q == 0) {
      *this = {S(1), S(0)};
      if (r != nullptr) *r = abs(p);
      return;
    }
    const S tangent = is_flat ? S(q / p) : S(p / q), root = sqrt(1.0 + tangent * tangent);
    const S length = (is_flat ? p : q) < 0 ? S(-root) : root, larger = 1.0 / length,
            smaller = tangent * larger;
    const S sum = (is_flat ? p : q) * length;
    c_ = is_flat ? larger : smaller;
    s_ = is_flat ? S(-smaller) : S(-larger);
    if (r != nullptr) *r = sum;
  }

 private:
  S c_, s_;
};
}  // namespace Eigen

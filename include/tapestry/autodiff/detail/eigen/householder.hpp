#pragma once
#include <tapestry/autodiff/detail/eigen/triangular_solve.hpp>

namespace tapestry::detail {
/// Replaces a vector x ≠ 0 whose entries behind the first are all 0 by its reflection to β·e₁,
/// 1 − τ v vᴴ, β = −sign(x₀)·|x|, v = (1, xᵢ / (x₀ − β)), as next to it: the limit, and differentiable. Eigen
/// takes τ = 0, which drops the derivatives of those entries.
/// \returns whether x is such a vector
template <class Vector, class S, Differentiable R>
[[nodiscard]] bool reflect_axis(Vector& x, S& tau, R& beta) {
  using B = decltype(base_value(beta));
  constexpr B least = std::numeric_limits<B>::min();
  if (x.size() < 2 || !(base_value(R(Eigen::numext::abs2(x[0]))) > least)) return false;
  auto tail = x.tail(x.size() - 1);
  const R squared = tail.squaredNorm();
  if (base_value(squared) > least) return false;
  const S first = x[0];
  const R length = sqrt(R(Eigen::numext::abs2(first) + squared));
  beta = Eigen::numext::real(first) >= 0 ? R(-length) : length;
  tail /= S(first - S(beta));
  tau = Eigen::numext::conj(S((S(beta) - first) / S(beta)));
  return true;
}
}  // namespace tapestry::detail

namespace Eigen {
/// Part of a vector of variables, as Eigen's own. Its decompositions make their reflections of such parts;
/// see tapestry::detail::reflect_axis().
template <tapestry::detail::MatrixOfDerivatives Vector, int Size>
class VectorBlock<Vector, Size>
    : public Block<Vector, (internal::traits<Vector>::Flags & RowMajorBit) != 0 ? 1 : Size,
                   (internal::traits<Vector>::Flags & RowMajorBit) != 0 ? Size : 1> {
  static constexpr bool is_row = (internal::traits<Vector>::Flags & RowMajorBit) != 0;
  using Base = Block<Vector, is_row ? 1 : Size, is_row ? Size : 1>;

 public:
  EIGEN_DENSE_PUBLIC_INTERFACE(VectorBlock)
  using Base::operator=;

  VectorBlock(Vector& vector, Index start, Index size)
      : Base(vector, is_row ? 0 : start, is_row ? start : 0, is_row ? 1 : size, is_row ? size : 1) {}
  VectorBlock(Vector& vector, Index start) : Base(vector, is_row ? 0 : start, is_row ? start : 0) {}

  void makeHouseholderInPlace(Scalar& tau, RealScalar& beta) {
    if (!tapestry::detail::reflect_axis(*this, tau, beta)) Base::makeHouseholderInPlace(tau, beta);
  }
};

namespace internal {
template <class Matrix, int Size, bool IsComplex>
struct tridiagonalization_inplace_selector;

/// Computes three rows as any other size: Eigen's own form for three drops derivatives of an entry that is 0.
template <tapestry::detail::MatrixOfDifferentiable Matrix>
struct tridiagonalization_inplace_selector<Matrix, 3, false>
    : tridiagonalization_inplace_selector<Matrix, Dynamic, false> {};
}  // namespace internal
}  // namespace Eigen

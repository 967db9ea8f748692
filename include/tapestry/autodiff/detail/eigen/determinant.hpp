#pragma once
#include <tapestry/autodiff/detail/eigen/triangular_solve.hpp>

namespace Eigen::internal {
template <class Matrix, int Size>
struct determinant_impl;

/// Determinant of variables of more than four rows, as Eigen's own. Partial pivoting skips a column without a
/// pivot; so a singular matrix is decomposed again with full pivoting, which leaves zeros only at the end.
/// Their determinant is right to second order.
template <class Matrix, int Size>
requires(tapestry::detail::HasDerivatives<typename Matrix::Scalar> &&
         (Size == Dynamic || Size > 4)) struct determinant_impl<Matrix, Size> {
  using Scalar = typename Matrix::Scalar;
  static Scalar run(const Matrix& a) {
    if (a.rows() == 0) return Scalar(1);
    const Scalar determinant = a.partialPivLu().determinant();
    if (determinant != Scalar(0)) return determinant;
    const auto lu = a.fullPivLu();
    const auto& u = lu.matrixLU();
    const Index rank = lu.nonzeroPivots(), n = a.rows();
    const Scalar sign(static_cast<double>(lu.permutationP().determinant() * lu.permutationQ().determinant()));
    const Scalar last =
        n - rank == 2 ? Scalar(u(rank, rank) * u(rank + 1, rank + 1) - u(rank, rank + 1) * u(rank + 1, rank))
                      : Scalar(u.diagonal().tail(n - rank).prod());
    return Scalar(sign * u.diagonal().head(rank).prod()) * last;
  }
};
}  // namespace Eigen::internal

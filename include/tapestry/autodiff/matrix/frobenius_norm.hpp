#pragma once
#include <cmath>
#include <concepts>
#include <tapestry/autodiff/matrix/record_matrix.hpp>

namespace tapestry::matrix {

/// √(Σ A[i, j]²), as one record, without overflow or underflow on the way; 0 of an empty matrix.
/// Ā = A / norm · adjoint, and 0, a subgradient, where the norm is 0.
/// \param a  A, [M, N] or [N], of floating-point variables: Eigen matrix, array variable or formula
template <detail::AnyMatrix A>
requires detail::holds_variables<A> && std::floating_point<detail::MatrixScalar<A>>
[[nodiscard]] auto frobenius_norm(const A& a) {
  using T = detail::MatrixScalar<A>;
  using Matrix = detail::DenseMatrix<T>;
  const auto input = detail::matrix_input<T>(a);
  const T largest =
      input.value.size() == 0 ? T(0) : input.value.cwiseAbs().template maxCoeff<Eigen::PropagateNaN>();
  const T scale = largest > T(0) && std::isfinite(largest) ? largest : T(1);
  const Matrix scaled = input.value / scale;
  const T scaled_norm = scaled.norm();
  const auto pullback = [scaled, scaled_norm](const T& value_adjoint, Matrix* a_adjoint) {
    *a_adjoint = scaled_norm == T(0) ? scaled : Matrix(scaled * (value_adjoint / scaled_norm));
  };
  return detail::record_number<T>(scale * scaled_norm, pullback, input);
}

}  // namespace tapestry::matrix

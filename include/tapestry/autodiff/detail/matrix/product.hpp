#pragma once
#include <tapestry/autodiff/detail/matrix/record_matrix.hpp>

namespace tapestry::matrix {
/// C = A B of Eigen matrices, [M, K] and [K, N], giving [M, N], as one record; Eigen's own A * B records
/// every entry. For arrays take matmul(). One of them may be plain.
///
///   Ā = C̄ Bᵀ,  B̄ = Aᵀ C̄
///
/// Source: Giles 2008, "Collected matrix derivative results for forward and reverse mode algorithmic
/// differentiation", 2.2.2.
///
/// \param a  A, an empty inner extent gives zeros
/// \param b  B, a matrix or a vector
/// \returns  C, a matrix or a vector as b
/// \throws ShapeError if the inner extents differ
template <detail::EigenMatrix A, detail::EigenMatrix B>
requires detail::MatrixBeside<B, A>
[[nodiscard]] auto product(const A& a, const B& b) {
  using T = detail::MatrixScalar<A, B>;
  using Matrix = detail::DenseMatrix<T>;
  const auto left = detail::matrix_input<T>(a);
  const auto right = detail::matrix_input<T>(b);
  if (left.value.cols() != right.value.rows())
    throw ShapeError({"product: b is ", detail::shape_text(right.value), ", expected ", left.value.cols(),
                      " rows for a ", detail::shape_text(left.value)});
  const Matrix value = left.value * right.value;
  const auto pullback = [a = left.value, b = right.value](const Matrix& value_adjoint, Matrix* a_adjoint,
                                                          Matrix* b_adjoint) {
    if (a_adjoint != nullptr) *a_adjoint = value_adjoint * b.transpose();
    if (b_adjoint != nullptr) *b_adjoint = a.transpose() * value_adjoint;
  };
  return detail::record_matrix<detail::columns_of<B>()>(value, pullback, left, right);
}

/// √(Σ A[i, j]²), as one record, without overflow or underflow on the way; 0 of an empty matrix.
/// Ā = A / norm · adjoint, and 0, a subgradient, where the norm is 0.
/// \param a  A, [M, N] or [N], of floating-point variables: Eigen matrix, array variable or formula
template <detail::MatrixOfFloats A>
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

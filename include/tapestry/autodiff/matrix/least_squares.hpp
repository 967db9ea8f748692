#pragma once
#include <Eigen/QR>
#include <memory>
#include <tapestry/autodiff/matrix/record_matrix.hpp>
#include <tapestry/core/error.hpp>

namespace tapestry::matrix {

/// X that makes the columns of A X − B shortest, by QR decomposition with column pivoting, as one record. One
/// of them may be plain. With the residual R = B − A X:
///
///   Y = (Aᵀ A)⁻¹ X̄,  B̄ = A Y,  Ā = R Yᵀ − B̄ Xᵀ
///
/// which follows from Aᵀ A X = Aᵀ B; Y and B̄ come from the decomposition, so that A's condition is not
/// squared.
///
/// \param a  A, [M, N], M ≥ N, its columns independent; N may be 0
/// \param b  B, [M, K] or [M]
/// \returns  X, [N, K] or [N]: an array variable if a or b is an array, else an Eigen matrix of variables
/// \throws ShapeError if a has more columns than rows, or b has other than M rows
/// \throws NumericError if a number of a is not finite, or its columns are dependent up to rounding of the
///         longest
template <detail::AnyMatrix A, detail::AnyMatrix B>
requires(detail::holds_variables<A> || detail::holds_variables<B>)
    [[nodiscard]] auto least_squares(const A& a, const B& b) {
  using T = detail::MatrixScalar<A, B>;
  using Matrix = detail::DenseMatrix<T>;
  const auto left = detail::matrix_input<T>(a);
  const auto right = detail::matrix_input<T>(b);
  const Eigen::Index columns = left.value.cols();
  if (left.value.rows() < columns)
    throw ShapeError("least_squares: a is " + detail::shape_text(left.value) +
                     ", expected no more columns than rows");
  detail::require_equal_rows<T>("least_squares", left.value, right.value);
  if (!left.value.allFinite()) throw NumericError("least_squares: a has a number that is not finite");
  const auto qr = std::make_shared<Eigen::ColPivHouseholderQR<Matrix>>(left.value.rows(), columns);
  if (columns > 0) qr->compute(left.value);
  if (columns > 0 && qr->rank() < columns)
    throw NumericError("least_squares: the columns of a are dependent");
  const Matrix x = columns > 0 ? Matrix(qr->solve(right.value)) : Matrix(0, right.value.cols());
  const auto pullback = [qr, x, residual = Matrix(right.value - left.value * x)](
                            const Matrix& value_adjoint, Matrix* a_adjoint, Matrix* b_adjoint) {
    const Eigen::Index n = x.rows();
    Matrix of_b = Matrix::Zero(residual.rows(), residual.cols());
    if (n > 0) {
      const auto r = qr->matrixQR().topLeftCorner(n, n).template triangularView<Eigen::Upper>();
      Matrix y = qr->colsPermutation().transpose() * value_adjoint;
      r.transpose().solveInPlace(y);
      of_b.topRows(n) = y;
      of_b.applyOnTheLeft(qr->householderQ());
      r.solveInPlace(y);
      y = (qr->colsPermutation() * y).eval();
      if (a_adjoint != nullptr) *a_adjoint = residual * y.transpose() - of_b * x.transpose();
    } else if (a_adjoint != nullptr) {
      a_adjoint->resize(residual.rows(), 0);
    }
    if (b_adjoint != nullptr) *b_adjoint = of_b;
  };
  return detail::record_matrix<detail::columns_of<B>()>(x, pullback, left, right);
}

}  // namespace tapestry::matrix

#pragma once
#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <Eigen/QR>
#include <tapestry/autodiff/detail/matrix/record_matrix.hpp>

namespace tapestry {
namespace detail {
template <class T>
using LuDecomposition = Eigen::PartialPivLU<DenseMatrix<T>>;

/// \throws ShapeError if a is not square, NumericError if a pivot is 0
template <class T>
[[nodiscard]] std::shared_ptr<const LuDecomposition<T>> lu_of(const char* operation,
                                                              const DenseMatrix<T>& a) {
  require_square(operation, a);
  auto lu = std::make_shared<const LuDecomposition<T>>(a);
  for (Eigen::Index i = 0; i < a.rows(); ++i)
    if (lu->matrixLU()(i, i) == 0) throw NumericError({operation, ": a is singular"});
  return lu;
}

template <class T>
using CholeskyDecomposition = Eigen::LLT<DenseMatrix<T>>;

/// \throws ShapeError if a is not square, NumericError if it is not positive definite
template <class T>
[[nodiscard]] std::shared_ptr<const CholeskyDecomposition<T>> cholesky_of(const char* operation,
                                                                          const DenseMatrix<T>& a) {
  require_square(operation, a);
  auto decomposition = std::make_shared<const CholeskyDecomposition<T>>(a);
  if (decomposition->info() != Eigen::Success)
    throw NumericError({operation, ": a is not positive definite"});
  return decomposition;
}

/// Adjoint of a symmetric matrix whose lower triangle alone was read: an entry below
/// the diagonal stands for two.
template <class T>
void fold_into_lower(DenseMatrix<T>& adjoint) {
  for (Eigen::Index j = 0; j < adjoint.cols(); ++j)
    for (Eigen::Index i = j + 1; i < adjoint.rows(); ++i) {
      adjoint(i, j) += adjoint(j, i);
      adjoint(j, i) = T(0);
    }
}
}  // namespace detail

namespace matrix {
/// Which part of a triangular matrix is read.
enum class Triangle { lower, upper };

/// X of A X = B, by LU decomposition with partial pivoting, as one record. One of them may be plain.
///
///   B̄ = A⁻ᵀ X̄,  Ā = −B̄ Xᵀ
///
/// The reverse sweep uses the decomposition again. Source: Giles 2008, "Collected matrix derivative results
/// for forward and reverse mode algorithmic differentiation", 2.3.1. NaN gives NaN. For a matrix that is
/// singular only up to rounding the result is large, not an error.
///
/// \param a  A, [N, N]: Eigen matrix, array variable or formula of them; N may be 0
/// \param b  B, [N, K] or [N]
/// \returns  X, of b's extents: an array variable if a or b is an array, else an Eigen matrix of variables
/// \throws ShapeError if a is not square or b has other than N rows
/// \throws NumericError if a is singular: a pivot is exactly 0
template <detail::AnyMatrix A, detail::MatrixBeside<A> B>
[[nodiscard]] auto solve(const A& a, const B& b) {
  using T = detail::MatrixScalar<A, B>;
  using Matrix = detail::DenseMatrix<T>;
  const auto left = detail::matrix_input<T>(a);
  const auto right = detail::matrix_input<T>(b);
  const auto lu = detail::lu_of<T>("solve", left.value);
  detail::require_equal_rows("solve", left.value, right.value);
  const Matrix x = lu->solve(right.value);
  const auto pullback = [lu, x](const Matrix& value_adjoint, Matrix* a_adjoint, Matrix* b_adjoint) {
    const Matrix of_b = lu->transpose().solve(value_adjoint);
    if (a_adjoint != nullptr) *a_adjoint = -of_b * x.transpose();
    if (b_adjoint != nullptr) *b_adjoint = of_b;
  };
  return detail::record_matrix<detail::columns_of<B>()>(x, pullback, left, right);
}

/// X of A X = B for a symmetric, positive definite A, by Cholesky decomposition, as one record. Reads A's
/// lower triangle alone. It receives the whole adjoint: an entry below the diagonal stands for two.
///
///   B̄ = A⁻¹ X̄,  S = −B̄ Xᵀ,  Ā[i, j] = S[i, j] + S[j, i] below the diagonal, S[i, i] on it
///
/// \param a  A, [N, N]; N may be 0
/// \param b  B, [N, K] or [N]
/// \returns  X, as solve()
/// \throws ShapeError as solve(), NumericError if a is not positive definite
template <detail::AnyMatrix A, detail::MatrixBeside<A> B>
[[nodiscard]] auto solve_positive_definite(const A& a, const B& b) {
  using T = detail::MatrixScalar<A, B>;
  using Matrix = detail::DenseMatrix<T>;
  const auto left = detail::matrix_input<T>(a);
  const auto right = detail::matrix_input<T>(b);
  const auto decomposition = detail::cholesky_of<T>("solve_positive_definite", left.value);
  detail::require_equal_rows("solve_positive_definite", left.value, right.value);
  const Matrix x = decomposition->solve(right.value);
  const auto pullback = [decomposition, x](const Matrix& value_adjoint, Matrix* a_adjoint,
                                           Matrix* b_adjoint) {
    const Matrix of_b = decomposition->solve(value_adjoint);
    if (b_adjoint != nullptr) *b_adjoint = of_b;
    if (a_adjoint == nullptr) return;
    *a_adjoint = -of_b * x.transpose();
    detail::fold_into_lower(*a_adjoint);
  };
  return detail::record_matrix<detail::columns_of<B>()>(x, pullback, left, right);
}

/// X of A X = B for a triangular A, by substitution, as one record. The other triangle is not read, and its
/// adjoint is 0.
///
///   B̄ = A⁻ᵀ X̄,  Ā = −B̄ Xᵀ within the triangle
///
/// \param a         A, [N, N]; N may be 0
/// \param b         B, [N, K] or [N]
/// \param triangle  which part of a to read, the diagonal included
/// \returns         X, as solve()
/// \throws ShapeError as solve(), NumericError if a number of the diagonal is 0
template <detail::AnyMatrix A, detail::MatrixBeside<A> B>
[[nodiscard]] auto solve_triangular(const A& a, const B& b, Triangle triangle) {
  using T = detail::MatrixScalar<A, B>;
  using Matrix = detail::DenseMatrix<T>;
  const auto left = detail::matrix_input<T>(a);
  const auto right = detail::matrix_input<T>(b);
  detail::require_square("solve_triangular", left.value);
  detail::require_equal_rows("solve_triangular", left.value, right.value);
  for (Eigen::Index i = 0; i < left.value.rows(); ++i)
    if (left.value(i, i) == 0) throw NumericError("solve_triangular: a is singular");
  Matrix x = right.value;
  const bool is_lower = triangle == Triangle::lower;
  is_lower ? left.value.template triangularView<Eigen::Lower>().solveInPlace(x)
           : left.value.template triangularView<Eigen::Upper>().solveInPlace(x);
  const auto pullback = [is_lower, a = left.value, x](const Matrix& value_adjoint, Matrix* a_adjoint,
                                                      Matrix* b_adjoint) {
    Matrix of_b = value_adjoint;
    is_lower ? a.template triangularView<Eigen::Lower>().transpose().solveInPlace(of_b)
             : a.template triangularView<Eigen::Upper>().transpose().solveInPlace(of_b);
    if (b_adjoint != nullptr) *b_adjoint = of_b;
    if (a_adjoint == nullptr) return;
    *a_adjoint = Matrix::Zero(a.rows(), a.cols());
    const Matrix whole = -of_b * x.transpose();
    is_lower ? void(a_adjoint->template triangularView<Eigen::Lower>() = whole)
             : void(a_adjoint->template triangularView<Eigen::Upper>() = whole);
  };
  return detail::record_matrix<detail::columns_of<B>()>(x, pullback, left, right);
}

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
template <detail::AnyMatrix A, detail::MatrixBeside<A> B>
[[nodiscard]] auto least_squares(const A& a, const B& b) {
  using T = detail::MatrixScalar<A, B>;
  using Matrix = detail::DenseMatrix<T>;
  const auto left = detail::matrix_input<T>(a);
  const auto right = detail::matrix_input<T>(b);
  const Eigen::Index columns = left.value.cols();
  if (left.value.rows() < columns)
    throw ShapeError(
        {"least_squares: a is ", detail::shape_text(left.value), ", expected no more columns than rows"});
  detail::require_equal_rows("least_squares", left.value, right.value);
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
}  // namespace matrix
}  // namespace tapestry

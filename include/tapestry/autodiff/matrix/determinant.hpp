#pragma once
#include <tapestry/autodiff/matrix/solve.hpp>

namespace tapestry {
namespace detail {
/// Turns the adjoint of a small L, [N, N], into that of A = L Lᵀ, lower triangle alone: with S = L⁻ᵀ Φ(Lᵀ L̄)
/// L⁻¹, where Φ takes the lower triangle and half the diagonal, Ā = S + Sᵀ below the diagonal and S on it.
template <class Factor, class Adjoint>
void pull_back_small_factor(const Factor& l, Adjoint&& adjoint) {
  using T = typename Factor::Scalar;
  const DenseMatrix<T> factor = l.template triangularView<Eigen::Lower>();
  const DenseMatrix<T> all = adjoint.template triangularView<Eigen::Lower>();
  DenseMatrix<T> s = factor.transpose() * all;
  s.template triangularView<Eigen::StrictlyUpper>().setZero();
  s.diagonal() /= T(2);
  const auto lower = factor.template triangularView<Eigen::Lower>();
  lower.transpose().solveInPlace(s);
  lower.template solveInPlace<Eigen::OnTheRight>(s);
  fold_into_lower(s);
  adjoint = s;
}

/// Turns the adjoint of L, [N, N], into the adjoint of the lower triangle of A = L Lᵀ, block by block from
/// the last, by products of matrices and two thirds of N³ operations. Source: Murray 2016, "Differentiation
/// of the Cholesky decomposition", section 4.2; its names. The upper triangle of the adjoint becomes 0.
template <class T>
void pull_back_factor(const DenseMatrix<T>& l, DenseMatrix<T>& adjoint) {
  constexpr Eigen::Index block = 16;
  const Eigen::Index n = l.rows();
  for (Eigen::Index end = n; end > 0;) {
    const Eigen::Index begin = std::max<Eigen::Index>(0, end - block), size = end - begin, below = n - end;
    const auto r = l.block(begin, 0, size, begin), b = l.block(end, 0, below, begin);
    const auto d = l.block(begin, begin, size, size), c = l.block(end, begin, below, size);
    auto r_adjoint = adjoint.block(begin, 0, size, begin), b_adjoint = adjoint.block(end, 0, below, begin);
    auto d_adjoint = adjoint.block(begin, begin, size, size),
         c_adjoint = adjoint.block(end, begin, below, size);
    d.template triangularView<Eigen::Lower>().template solveInPlace<Eigen::OnTheRight>(c_adjoint);
    b_adjoint.noalias() -= c_adjoint * r;
    d_adjoint.noalias() -= c_adjoint.transpose() * c;
    pull_back_small_factor(d, d_adjoint);
    r_adjoint.noalias() -= c_adjoint.transpose() * b;
    const DenseMatrix<T> both = d_adjoint + d_adjoint.transpose();
    r_adjoint.noalias() -= both * r;
    end = begin;
  }
  adjoint.template triangularView<Eigen::StrictlyUpper>().setZero();
}

/// The inverse of a lower triangular matrix, [N, N], rows of a block at a time, by products of matrices; with
/// a diagonal of ones if Mode is Eigen::UnitLower.
template <unsigned Mode, class T, class Factor>
[[nodiscard]] DenseMatrix<T> inverse_of_lower(const Factor& l) {
  constexpr Eigen::Index block = 24;
  const Eigen::Index n = l.rows();
  DenseMatrix<T> inverse = DenseMatrix<T>::Zero(n, n);
  for (Eigen::Index begin = 0; begin < n; begin += block) {
    const Eigen::Index size = std::min(block, n - begin);
    const auto diagonal = l.block(begin, begin, size, size).template triangularView<Mode>();
    inverse.block(begin, begin, size, size).setIdentity();
    auto rows = inverse.block(begin, 0, size, begin + size);
    rows.leftCols(begin).noalias() -= l.block(begin, 0, size, begin) * inverse.topLeftCorner(begin, begin);
    diagonal.solveInPlace(rows);
  }
  return inverse;
}

/// xᵀ y of lower triangular matrices, without the products by their zeros.
template <class T>
[[nodiscard]] DenseMatrix<T> transposed_times_lower(const DenseMatrix<T>& x, const DenseMatrix<T>& y) {
  constexpr Eigen::Index block = 24;
  const Eigen::Index n = x.rows();
  DenseMatrix<T> product = DenseMatrix<T>::Zero(n, n);
  for (Eigen::Index begin = 0; begin < n; begin += block) {
    const Eigen::Index size = std::min(block, n - begin), end = begin + size;
    product.topLeftCorner(end, end).noalias() +=
        x.block(begin, 0, size, end).transpose() * y.block(begin, 0, size, end);
  }
  return product;
}

/// Factor for A before it is inverted: a reciprocal of a pivot overflows below 2⁻¹⁰²⁴, and then meets zeros.
/// 1 where no pivot is so small, or another entry would overflow.
template <class T>
[[nodiscard]] Base<T> scale_of_inversion(const LuDecomposition<T>& lu) {
  using Number = Base<T>;
  Number least = 1, largest = 0;
  for (Eigen::Index i = 0; i < lu.rows(); ++i) {
    least = std::min(least, std::abs(number_of(T(lu.matrixLU()(i, i)))));
    for (Eigen::Index j = i; j < lu.cols(); ++j)
      largest = std::max(largest, std::abs(number_of(T(lu.matrixLU()(i, j)))));
  }
  // It makes the least denormal number of any type a normal one.
  constexpr auto scale = static_cast<Number>(0x1p74F);
  const bool fits = largest < std::numeric_limits<Number>::max() / scale;
  return least < std::numeric_limits<Number>::min() && fits ? scale : Number(1);
}

/// A⁻ᵀ of P A = L U: Pᵀ (L⁻ᵀ U⁻ᵀ), two thirds of the work of solving for all columns.
template <class T>
[[nodiscard]] DenseMatrix<T> transposed_inverse(const LuDecomposition<T>& lu) {
  const DenseMatrix<T> lower = inverse_of_lower<Eigen::UnitLower, T>(lu.matrixLU());
  const Base<T> scale = scale_of_inversion<T>(lu);
  DenseMatrix<T> transposed_upper = lu.matrixLU().transpose();
  if (scale != 1) transposed_upper *= T(scale);
  DenseMatrix<T> inverse =
      lu.permutationP().transpose() *
      transposed_times_lower<T>(lower, inverse_of_lower<Eigen::Lower, T>(transposed_upper));
  if (scale != 1) inverse *= T(scale);
  return inverse;
}

/// A⁻¹ of A = L Lᵀ: L⁻ᵀ L⁻¹.
template <class T>
[[nodiscard]] DenseMatrix<T> positive_definite_inverse(const CholeskyDecomposition<T>& decomposition) {
  const DenseMatrix<T> lower = inverse_of_lower<Eigen::Lower, T>(decomposition.matrixLLT());
  return transposed_times_lower<T>(lower, lower);
}
}  // namespace detail

namespace matrix {
/// The lower triangular L of A = L Lᵀ for a symmetric, positive definite A, as one record. Reads A's lower
/// triangle alone. It receives the whole adjoint: an entry below the diagonal stands for two. NaN gives NaN.
///
/// \param a  A, [N, N]: Eigen matrix of variables, array variable or formula; N may be 0
/// \returns  L, [N, N], held as a is, zeros above the diagonal, whose adjoint is not used
/// \throws ShapeError if a is not square, NumericError if it is not positive definite
template <detail::MatrixOfVariables A>
[[nodiscard]] auto cholesky(const A& a) {
  using T = detail::MatrixScalar<A>;
  using Matrix = detail::DenseMatrix<T>;
  const auto input = detail::matrix_input<T>(a);
  const auto decomposition = detail::cholesky_of<T>("cholesky", input.value);
  const Matrix value = decomposition->matrixL();
  const auto pullback = [decomposition](const Matrix& value_adjoint, Matrix* a_adjoint) {
    *a_adjoint = value_adjoint;
    detail::pull_back_factor<T>(decomposition->matrixLLT(), *a_adjoint);
  };
  return detail::record_matrix<Eigen::Dynamic>(value, pullback, input);
}

/// C = A⁻¹, by LU decomposition with partial pivoting, as one record. To solve equations take solve().
///
///   Ā = −Cᵀ C̄ Cᵀ
///
/// Source: Giles 2008, 2.2.3. NaN gives NaN.
///
/// \param a  A, [N, N]: Eigen matrix of variables, array variable or formula; N may be 0
/// \returns  C, [N, N], held as a is
/// \throws ShapeError if a is not square, NumericError if it is singular: a pivot is exactly 0
template <detail::MatrixOfVariables A>
[[nodiscard]] auto inverse(const A& a) {
  using T = detail::MatrixScalar<A>;
  using Matrix = detail::DenseMatrix<T>;
  const auto input = detail::matrix_input<T>(a);
  const Matrix value = detail::transposed_inverse<T>(*detail::lu_of<T>("inverse", input.value)).transpose();
  const auto pullback = [value](const Matrix& value_adjoint, Matrix* a_adjoint) {
    const Matrix half = value.transpose() * value_adjoint;
    *a_adjoint = -half * value.transpose();
  };
  return detail::record_matrix<Eigen::Dynamic>(value, pullback, input);
}

/// log |det A|, by LU decomposition with partial pivoting, as one record; 0 for an empty matrix. Unlike
/// log(det A) it does not overflow where the determinant does.
///
///   Ā = A⁻ᵀ · adjoint
///
/// Source: Giles 2008, 2.2.4.
///
/// \param a  A, [N, N]: Eigen matrix of variables, array variable or formula
/// \returns  one number; the sign of det A is lost
/// \throws ShapeError if a is not square, NumericError if it is singular: a pivot is exactly 0
template <detail::MatrixOfVariables A>
[[nodiscard]] auto log_determinant(const A& a) {
  using T = detail::MatrixScalar<A>;
  using Matrix = detail::DenseMatrix<T>;
  const auto input = detail::matrix_input<T>(a);
  const auto lu = detail::lu_of<T>("log_determinant", input.value);
  using std::abs;
  using std::log;
  T value(0);
  for (Eigen::Index i = 0; i < input.value.rows(); ++i) value += T(log(T(abs(lu->matrixLU()(i, i)))));
  const auto pullback = [lu](const T& value_adjoint, Matrix* a_adjoint) {
    *a_adjoint = detail::transposed_inverse<T>(*lu) * value_adjoint;
  };
  return detail::record_number<T>(value, pullback, input);
}

/// log det A of a symmetric, positive definite A, by Cholesky decomposition: half the work. Reads A's lower
/// triangle alone. It receives the whole adjoint: an entry below the diagonal stands for two.
///
///   Ā[i, j] = 2 A⁻¹[i, j] · adjoint below the diagonal, A⁻¹[i, i] · adjoint on it
///
/// \param a  A, [N, N]: Eigen matrix of variables, array variable or formula
/// \returns  one number; 0 of an empty matrix
/// \throws ShapeError if a is not square, NumericError if it is not positive definite
template <detail::MatrixOfVariables A>
[[nodiscard]] auto log_determinant_positive_definite(const A& a) {
  using T = detail::MatrixScalar<A>;
  using Matrix = detail::DenseMatrix<T>;
  const auto input = detail::matrix_input<T>(a);
  const auto decomposition = detail::cholesky_of<T>("log_determinant_positive_definite", input.value);
  using std::log;
  T value(0);
  for (Eigen::Index i = 0; i < input.value.rows(); ++i) value += 2 * T(log(decomposition->matrixLLT()(i, i)));
  const auto pullback = [decomposition](const T& value_adjoint, Matrix* a_adjoint) {
    *a_adjoint = detail::positive_definite_inverse<T>(*decomposition) * value_adjoint;
    detail::fold_into_lower(*a_adjoint);
  };
  return detail::record_number<T>(value, pullback, input);
}
}  // namespace matrix
}  // namespace tapestry

#pragma once
#include <algorithm>
#include <memory>
#include <tapestry/autodiff/matrix/solve.hpp>

namespace tapestry {
namespace detail {

/// Of a small L, [N, N], turns its adjoint into that of A = L Lᵀ, lower triangle alone: with
/// S = L⁻ᵀ Φ(Lᵀ L̄) L⁻¹, where Φ takes the lower triangle and half the diagonal, Ā = S + Sᵀ below the diagonal
/// and S on it.
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

/// Turns the adjoint of L, [N, N], into that of the lower triangle of A = L Lᵀ, block by block from the last,
/// by products of matrices and two thirds of N³ operations. Source: Murray 2016, "Differentiation of the
/// Cholesky decomposition", section 4.2; its names. The upper triangle of the adjoint becomes 0.
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
}  // namespace detail

namespace matrix {

/// The lower triangular L of A = L Lᵀ for a symmetric, positive definite A, as one record. Only A's lower
/// triangle is read, and has all of the adjoint: an entry below the diagonal stands for two. NaN gives NaN.
///
/// \param a  A, [N, N]: Eigen matrix of variables, array variable or formula; N may be 0
/// \returns  L, [N, N], held as a is, zeros above the diagonal, whose adjoint is not used
/// \throws ShapeError if a is not square, NumericError if it is not positive definite
template <detail::AnyMatrix A>
requires detail::holds_variables<A>
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

}  // namespace matrix
}  // namespace tapestry

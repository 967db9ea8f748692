#pragma once
#include <Eigen/Eigenvalues>
#include <tapestry/autodiff/matrix/solve.hpp>

namespace tapestry {
namespace detail {
/// A = V diag(w) Vᵀ.
template <class T>
struct EigenPairs {
  DenseMatrix<T> w, v;
};

/// Eigenvalues and vectors of the lower triangle of a; w ascends.
/// \throws ShapeError if a is not square, NumericError if a number is not finite
template <std::floating_point T>
[[nodiscard]] std::shared_ptr<const EigenPairs<T>> eigen_pairs_of(const char* operation,
                                                                  const DenseMatrix<T>& a) {
  require_square(operation, a);
  if (!a.allFinite()) throw NumericError({operation, ": a has a number that is not finite"});
  if (a.rows() == 0)
    return std::make_shared<const EigenPairs<T>>(EigenPairs<T>{DenseMatrix<T>(0, 1), DenseMatrix<T>(0, 0)});
  const Eigen::SelfAdjointEigenSolver<DenseMatrix<T>> solver(a);
  if (solver.info() != Eigen::Success) throw NumericError({operation, ": the iteration does not converge"});
  return std::make_shared<const EigenPairs<T>>(EigenPairs<T>{solver.eigenvalues(), solver.eigenvectors()});
}

/// turn / gap: rate at which two eigenvectors mix, by the gap of their eigenvalues. If the gap is only
/// rounding, there is no derivative, except for functions of the space that both span, which no turn changes.
/// \param gap, turn          of the two
/// \param gap_size, turn_size  sizes below which they are only rounding
template <std::floating_point T>
[[nodiscard]] T divided_by_gap(const char* operation, T turn, T gap, T turn_size, T gap_size) {
  using std::abs;
  if (abs(gap) > gap_size) return turn / gap;
  if (abs(turn) <= turn_size) return T(0);
  if (turn != turn) return turn;  // the adjoint is NaN
  throw NumericError({operation, ": two values are equal, so that their vectors have no derivative"});
}
}  // namespace detail

namespace matrix {
/// Result of symmetric_eigen(): arrays or Eigen matrices of variables.
template <class Values, class Vectors>
struct SymmetricEigen {
  Values values;    ///< w, [N], ascending
  Vectors vectors;  ///< V, [N, N], a unit vector a column, its sign as Eigen's solver gives it
};

/// The eigenvalues w and vectors V of a symmetric A = V diag(w) Vᵀ, as one record each, of one decomposition.
/// Reads A's lower triangle alone. It receives the whole adjoint: an entry below the
/// diagonal stands for two. With
///
///   S = V diag(w̄) Vᵀ + V (F ∘ Vᵀ V̄) Vᵀ,  F[i, j] = 1 / (w[j] − w[i]), 0 on the diagonal,
///
/// Ā[i, j] = S[i, j] + S[j, i] below the diagonal, S[i, i] on it. Source: Giles 2008, "Collected matrix
/// derivative results for forward and reverse mode algorithmic differentiation", 3.1.
///
/// Equal eigenvalues have no derivative each. The result is then one of many, right for symmetric functions
/// of all of them, such as their sum. Their vectors may then be used only in functions of the space that they
/// span, such as V Vᵀ. Equal means up to 16 N rounding errors of the largest.
///
/// \param a  A, [N, N], of floating-point variables: Eigen matrix, array variable or formula; N may be 0
/// \returns  values and vectors, held as a is
/// \throws ShapeError   if a is not square
/// \throws NumericError if a number is not finite; in the reverse sweep, if eigenvectors of equal eigenvalues
///   have an adjoint that turns them
template <detail::MatrixOfFloats A>
[[nodiscard]] auto symmetric_eigen(const A& a) {
  using T = detail::MatrixScalar<A>;
  using Matrix = detail::DenseMatrix<T>;
  const auto input = detail::matrix_input<T>(a);
  const auto pairs = detail::eigen_pairs_of<T>("symmetric_eigen", input.value);
  const auto by_values = [pairs](const Matrix& value_adjoint, Matrix* a_adjoint) {
    *a_adjoint = pairs->v * value_adjoint.col(0).asDiagonal() * pairs->v.transpose();
    detail::fold_into_lower(*a_adjoint);
  };
  const auto by_vectors = [pairs](const Matrix& value_adjoint, Matrix* a_adjoint) {
    const Matrix& w = pairs->w;
    const Eigen::Index n = w.rows();
    Matrix inner = pairs->v.transpose() * value_adjoint;
    const T rounding = T(16) * static_cast<T>(n) * std::numeric_limits<T>::epsilon();
    const T gap_size = n == 0 ? T(0) : rounding * w.cwiseAbs().maxCoeff();
    const T turn_size = n == 0 ? T(0) : rounding * inner.cwiseAbs().maxCoeff();
    for (Eigen::Index j = 0; j < n; ++j)
      for (Eigen::Index i = 0; i <= j; ++i) {  // S need not be symmetric: its halves are added up below
        inner(i, j) = i == j ? T(0)
                             : detail::divided_by_gap("symmetric_eigen", inner(i, j) - inner(j, i),
                                                      w(j) - w(i), turn_size, gap_size);
        inner(j, i) = T(0);
      }
    *a_adjoint = pairs->v * inner * pairs->v.transpose();
    detail::fold_into_lower(*a_adjoint);
  };
  auto values = detail::record_matrix<1>(pairs->w, by_values, input);
  auto vectors = detail::record_matrix<Eigen::Dynamic>(pairs->v, by_vectors, input);
  return SymmetricEigen<decltype(values), decltype(vectors)>{std::move(values), std::move(vectors)};
}
}  // namespace matrix
}  // namespace tapestry

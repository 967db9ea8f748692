#pragma once
#include <Eigen/SparseCore>
#include <Eigen/SparseLU>
#include <tapestry/autodiff/detail/matrix/record_matrix.hpp>

namespace tapestry {
namespace detail {
template <class S>
struct SparseScalarOf {
  using type = void;
};
template <ScalarExpression S>
struct SparseScalarOf<S> {
  using type = typename S::ExpressionScalar;
};

/// The matrix by columns, and the slot of the entries in that order; an entry stored as 0 counts, too.
template <class T, class S>
[[nodiscard]] auto sparse_input(const Eigen::SparseMatrix<S>& entries, Eigen::SparseMatrix<T>& numbers) {
  MatrixInput<T, EntriesSlot<T>> input;
  if constexpr (std::is_same_v<S, T>) {
    numbers = entries;
  } else {
    numbers = entries.unaryExpr([](const S& entry) { return entry.value(); });
    for (Eigen::Index k = 0; k < entries.nonZeros(); ++k)
      input.slot.links.push_back(entries.valuePtr()[k].link());
    input.slot.drop_if_passive();
  }
  return input;
}

/// −B̄ Xᵀ at the entries of a, column by column.
template <class T>
[[nodiscard]] DenseMatrix<T> sparse_outer_product(const Eigen::SparseMatrix<T>& a, const DenseMatrix<T>& of_b,
                                                  const DenseMatrix<T>& x) {
  DenseMatrix<T> adjoint(a.nonZeros(), 1);
  Eigen::Index number = 0;
  for (Eigen::Index j = 0; j < a.outerSize(); ++j)
    for (typename Eigen::SparseMatrix<T>::InnerIterator entry(a, j); entry; ++entry)
      adjoint(number++) = -of_b.row(entry.row()).dot(x.row(j));
  return adjoint;
}
}  // namespace detail

namespace matrix {
/// X of A X = B for a sparse A, by Eigen's sparse LU decomposition, as one record. One of them may be plain.
///
///   B̄ = A⁻ᵀ X̄,  Ā[i, j] = −B̄[i, ·] · X[j, ·] at A's entries
///
/// The reverse sweep uses the decomposition again, and takes time in proportion to its entries and A's.
///
/// \param a  A, [N, N], Eigen::SparseMatrix of floating-point variables or of numbers; N may be 0
/// \param b  B, [N, K] or [N]: Eigen matrix, array variable or formula
/// \returns  X, of b's extents: an array variable if b is an array, else an Eigen matrix of variables
/// \throws ShapeError   if a is not square or b has other than N rows
/// \throws NumericError if a is singular: a pivot is exactly 0, or a column has no entry
template <class S, int Order, class Index, detail::AnyMatrix B>
requires(ScalarExpression<S> || detail::MatrixOfVariables<B>)
    [[nodiscard]] auto solve(const Eigen::SparseMatrix<S, Order, Index>& a, const B& b) {
  using Known = typename detail::SparseScalarOf<S>::type;
  using T = std::conditional_t<std::is_void_v<Known>, detail::MatrixScalar<B>, Known>;
  static_assert(std::floating_point<T>);
  using Matrix = detail::DenseMatrix<T>;
  using Numbers = Eigen::SparseMatrix<T>;
  auto numbers = std::make_shared<Numbers>();
  const auto left = detail::sparse_input<T>(Eigen::SparseMatrix<S>(a), *numbers);
  const auto right = detail::matrix_input<T>(b);
  detail::require_square("solve", *numbers);
  detail::require_equal_rows("solve", *numbers, right.value);
  const auto lu = std::make_shared<Eigen::SparseLU<Numbers>>();
  if (numbers->rows() > 0) lu->compute(*numbers);
  if (numbers->rows() > 0 && lu->info() != Eigen::Success) throw NumericError("solve: a is singular");
  const Matrix x = numbers->rows() > 0 ? Matrix(lu->solve(right.value)) : right.value;
  const auto pullback = [numbers, lu, x](const Matrix& value_adjoint, Matrix* a_adjoint, Matrix* b_adjoint) {
    const Matrix of_b = x.rows() > 0 ? Matrix(lu->transpose().solve(value_adjoint)) : value_adjoint;
    if (a_adjoint != nullptr) *a_adjoint = detail::sparse_outer_product<T>(*numbers, of_b, x);
    if (b_adjoint != nullptr) *b_adjoint = of_b;
  };
  return detail::record_matrix<detail::columns_of<B>()>(x, pullback, left, right);
}
}  // namespace matrix
}  // namespace tapestry

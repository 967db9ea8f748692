#pragma once
#include <tapestry/autodiff/eigen.hpp>
#include <tapestry/autodiff/jacobian.hpp>

namespace tapestry {
// The derivatives of derivatives.hpp and jacobian.hpp for Eigen: of a function of a column vector, with
// shapes. The function is called with an Eigen::Map<const Eigen::Matrix<S, N, 1>> of any scalar type S:
//
//   const auto f = [](const auto& x) { return x.squaredNorm() / x[0]; };
//   const Eigen::MatrixXd second = hessian(f, Eigen::VectorXd::Ones(3));

namespace detail {
/// A column vector of numbers.
template <class X>
concept EigenPoint = std::derived_from<X, Eigen::MatrixBase<X>> && X::ColsAtCompileTime == 1 &&
                     std::floating_point<typename X::Scalar>;

/// f of a span, for an f of Eigen's vectors; see derivatives.hpp. Each f gets a type of its own. f returns a
/// number, perhaps as a matrix of one entry, or if ReturnsVector a column vector.
template <class Function, int Rows, bool ReturnsVector = false>
struct OfEigenVector {
  const Function& f;

  template <class S>
  [[nodiscard]] auto map(std::span<const S> x) const {
    return Eigen::Map<const Eigen::Matrix<S, Rows, 1>>(x.data(), static_cast<Eigen::Index>(x.size()));
  }
  template <class S>
  [[nodiscard]] auto operator()(std::span<const S> x) const {
    if constexpr (ReturnsVector) {
      const auto results = f(map(x)).eval();
      static_assert(decltype(results)::ColsAtCompileTime == 1, "the function's result is no column vector");
      return std::vector<S>(results.data(), results.data() + results.size());
    } else if constexpr (requires { f(map(x)).eval(); }) {
      return S(f(map(x)).value());
    } else {
      return S(f(map(x)));
    }
  }
  /// Number of rows of its results, as known at compile time.
  template <class S>
  static constexpr int rows_of_results = std::remove_cvref_t<decltype(std::declval<Function>()(
      std::declval<Eigen::Map<const Eigen::Matrix<S, Rows, 1>>>()))>::RowsAtCompileTime;
};

/// The numbers of x, one behind the other.
template <class X>
[[nodiscard]] auto plain_vector(const X& x) {
  return Eigen::Matrix<typename X::Scalar, X::RowsAtCompileTime, 1>(x);
}
template <class T, int Rows>
[[nodiscard]] std::span<const T> as_span(const Eigen::Matrix<T, Rows, 1>& x) {
  return {x.data(), static_cast<std::size_t>(x.size())};
}

/// Numbers that lie row by row as a matrix of `columns` columns.
template <int Rows, int Columns, class T>
[[nodiscard]] Eigen::Matrix<T, Rows, Columns> as_matrix(const std::vector<T>& numbers, Eigen::Index rows,
                                                        Eigen::Index columns) {
  Eigen::Matrix<T, Rows, Columns> result(rows, columns);
  for (Eigen::Index i = 0; i < rows; ++i)
    for (Eigen::Index j = 0; j < columns; ++j)
      result(i, j) = numbers[static_cast<std::size_t>(i * columns + j)];
  return result;
}
}  // namespace detail

/// Result of gradient() of an Eigen vector.
template <class T, int Rows>
struct ValueAndEigenGradient {
  T value;
  Eigen::Matrix<T, Rows, 1> gradient;
};

/// Value and gradient, [N], of a function of an Eigen vector, [N].
template <class Function, detail::EigenPoint X>
[[nodiscard]] auto gradient(const Function& f, const X& x) {
  using T = typename X::Scalar;
  constexpr int rows = X::RowsAtCompileTime;
  const auto at = detail::plain_vector(x);
  const auto found = gradient<T>(detail::OfEigenVector<Function, rows>{f}, detail::as_span(at));
  return ValueAndEigenGradient<T, rows>{found.value, detail::as_matrix<rows, 1>(found.gradient, x.size(), 1)};
}

/// The Hessian, [N, N], of a function of an Eigen vector, [N]. Entries that are not known are NaN.
template <class Function, detail::EigenPoint X>
[[nodiscard]] auto hessian(const Function& f, const X& x) {
  using T = typename X::Scalar;
  constexpr int rows = X::RowsAtCompileTime;
  const auto at = detail::plain_vector(x);
  const auto found = hessian<T>(detail::OfEigenVector<Function, rows>{f}, detail::as_span(at));
  return detail::as_matrix<rows, rows>(found, x.size(), x.size());
}

/// The Jacobian, [M, N], of recorded variables by others, each an Eigen vector.
/// \param results    [M]
/// \param variables  [N]
/// \throws DomainError if one is not on the tape
template <std::floating_point T, int M, int N>
[[nodiscard]] Eigen::Matrix<T, M, N> jacobian(Tape<T>& tape, const Eigen::Matrix<Variable<T>, M, 1>& results,
                                              const Eigen::Matrix<Variable<T>, N, 1>& variables) {
  const std::vector<T> found = jacobian(tape, detail::as_span(results), detail::as_span(variables));
  return detail::as_matrix<M, N>(found, results.size(), variables.size());
}

/// The Jacobian, [M, N], of a function from Eigen vectors, [N], to Eigen vectors, [M]; forwards or
/// backwards as in jacobian.hpp.
template <class Function, detail::EigenPoint X>
[[nodiscard]] auto jacobian(const Function& f, const X& x) {
  using T = typename X::Scalar;
  constexpr int columns = X::RowsAtCompileTime;
  const detail::OfEigenVector<Function, columns, true> of_span{f};
  const auto at = detail::plain_vector(x);
  const DenseJacobian<T> found = jacobian<T>(of_span, detail::as_span(at));
  constexpr int rows = decltype(of_span)::template rows_of_results<T>;
  return detail::as_matrix<rows, columns>(found.entries, static_cast<Eigen::Index>(found.rows), x.size());
}
}  // namespace tapestry

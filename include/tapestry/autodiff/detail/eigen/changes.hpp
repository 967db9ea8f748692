#pragma once
#include <Eigen/Core>
#include <tapestry/autodiff/functions.hpp>

// Matrices computed from one of variables: values by Eigen's algorithm in numbers, and changes to first
// order. The numbers may be duals, which have derivatives of their own.

namespace tapestry::detail {
/// Variables of value 0: the derivatives alone.
template <class S>
using Changes = Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic>;
template <class S>
using Numbers = Eigen::Matrix<typename S::value_type, Eigen::Dynamic, Eigen::Dynamic>;

template <class Matrix>
[[nodiscard]] Numbers<typename Matrix::Scalar> numbers_of(const Matrix& a) {
  Numbers<typename Matrix::Scalar> numbers(a.rows(), a.cols());
  for (Eigen::Index i = 0; i < a.rows(); ++i)
    for (Eigen::Index j = 0; j < a.cols(); ++j) numbers(i, j) = a(i, j).value();
  return numbers;
}

/// Ȧ: A less its numbers.
template <class Matrix>
[[nodiscard]] Changes<typename Matrix::Scalar> changes_of(const Matrix& a) {
  Changes<typename Matrix::Scalar> changes(a.rows(), a.cols());
  for (Eigen::Index i = 0; i < a.rows(); ++i)
    for (Eigen::Index j = 0; j < a.cols(); ++j) changes(i, j) = a(i, j) - a(i, j).value();
  return changes;
}

/// B Ȧ, an operation an entry.
template <class S>
[[nodiscard]] Changes<S> of_changes(const Numbers<S>& b, const Changes<S>& changes) {
  using T = typename S::value_type;
  Changes<S> product(b.rows(), changes.cols());
  const auto count = static_cast<std::size_t>(changes.rows());
  for (Eigen::Index i = 0; i < b.rows(); ++i) {
    std::vector<T> partials;
    for (Eigen::Index j = 0; j < b.cols(); ++j) partials.push_back(b(i, j));
    for (Eigen::Index k = 0; k < changes.cols(); ++k)
      product(i, k) =
          of_range(T(0), std::span<const S>(changes.data() + k * changes.rows(), count), partials);
  }
  return product;
}
}  // namespace tapestry::detail

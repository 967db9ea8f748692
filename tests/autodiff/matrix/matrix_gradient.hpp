#pragma once
#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/autodiff/eigen.hpp>
#include <tapestry/core/random.hpp>
#include "../../support/active_tape.hpp"
#include "../../support/catch.hpp"
#include "../../support/finite_difference.hpp"

namespace tapestry::test {
using LongMatrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
template <class S>
using MatrixOf = Eigen::Matrix<S, Eigen::Dynamic, Eigen::Dynamic>;

inline Eigen::MatrixXd random_matrix(Eigen::Index rows, Eigen::Index columns, std::uint64_t seed) {
  Eigen::MatrixXd matrix(rows, columns);
  Random random(seed);
  for (Eigen::Index j = 0; j < columns; ++j)
    for (Eigen::Index i = 0; i < rows; ++i) matrix(i, j) = random.uniform(-1, 1);
  return matrix;
}
/// Eigenvalues from 1 to a few.
inline Eigen::MatrixXd random_positive_definite(Eigen::Index n, std::uint64_t seed) {
  const Eigen::MatrixXd a = random_matrix(n, n, seed);
  return a * a.transpose() / std::sqrt(static_cast<double>(n)) + Eigen::MatrixXd::Identity(n, n);
}

inline Array<double, 2> array_of_matrix(const Eigen::MatrixXd& matrix) {
  Array<double, 2> array(
      Extents<2>{static_cast<std::size_t>(matrix.rows()), static_cast<std::size_t>(matrix.cols())});
  for (Eigen::Index i = 0; i < matrix.rows(); ++i)
    for (Eigen::Index j = 0; j < matrix.cols(); ++j)
      array(static_cast<std::size_t>(i), static_cast<std::size_t>(j)) = matrix(i, j);
  return array;
}

/// Σ w[i, j] · result[i, j], weights of order one.
inline double weight_of(std::size_t i, std::size_t j) {
  return std::cos(static_cast<double>(3 * i + 5 * j + 1));
}
template <class S, int Columns>
S weighted(const Eigen::Matrix<S, Eigen::Dynamic, Columns>& result) {
  S sum = 0;
  for (Eigen::Index i = 0; i < result.rows(); ++i)
    for (Eigen::Index j = 0; j < result.cols(); ++j)
      sum += S(weight_of(static_cast<std::size_t>(i), static_cast<std::size_t>(j))) * result(i, j);
  return sum;
}
inline Variable<double> weighted(const ArrayVariable<double, 2>& result) {
  Array<double, 2> weights(result.shape());
  for (std::size_t i = 0; i < weights.shape(0); ++i)
    for (std::size_t j = 0; j < weights.shape(1); ++j) weights(i, j) = weight_of(i, j);
  return sum(result * weights);
}
inline Variable<double> weighted(const ArrayVariable<double, 1>& result) {
  Array<double, 1> weights(result.shape());
  for (std::size_t i = 0; i < weights.size(); ++i) weights(i) = weight_of(i, 0);
  return sum(result * weights);
}
inline Variable<double> weighted(const Variable<double>& number) { return number; }
inline long double weighted(long double number) { return number; }

template <std::size_t N>
using Matrices = std::array<Eigen::MatrixXd, N>;

/// The gradient with the matrices held by Eigen, each entry a variable; repeats, for reverse() may.
template <class OnTape, std::size_t N>
Matrices<N> gradient_by_entries(const OnTape& f, const Matrices<N>& at) {
  ActiveTape<double> tape;
  std::array<MatrixOf<Variable<double>>, N> x;
  for (std::size_t k = 0; k < N; ++k) x[k] = at[k].unaryExpr([&](double entry) { return tape.input(entry); });
  const Variable<double> root = std::apply([&](const auto&... each) { return weighted(f(each...)); }, x);
  tape.reverse(root);
  tape.reverse(root);
  Matrices<N> gradient;
  for (std::size_t k = 0; k < N; ++k)
    gradient[k] = x[k].unaryExpr([](const Variable<double>& entry) { return entry.adjoint(); });
  return gradient;
}

/// The same with array variables.
template <class OnTape, std::size_t N>
Matrices<N> gradient_by_arrays(const OnTape& f, const Matrices<N>& at) {
  ActiveTape<double> tape;
  std::array<ArrayVariable<double, 2>, N> x;
  for (std::size_t k = 0; k < N; ++k) x[k] = tape.input(array_of_matrix(at[k]));
  const Variable<double> root = std::apply([&](const auto&... each) { return weighted(f(each...)); }, x);
  tape.reverse(root);
  tape.reverse(root);
  Matrices<N> gradient;
  for (std::size_t k = 0; k < N; ++k) {
    gradient[k].resize(at[k].rows(), at[k].cols());
    for (Eigen::Index i = 0; i < at[k].rows(); ++i)
      for (Eigen::Index j = 0; j < at[k].cols(); ++j)
        gradient[k](i, j) = x[k].adjoint()(static_cast<std::size_t>(i), static_cast<std::size_t>(j));
  }
  return gradient;
}

/// Central differences of a function in long double, extrapolated twice from h = 2⁻⁹ (error of order h⁶ and
/// ε/h: 1e-16 of the function's scale).
template <class Reference, std::size_t N>
Matrices<N> differences(const Reference& f, const Matrices<N>& at) {
  std::array<LongMatrix, N> x;
  for (std::size_t k = 0; k < N; ++k) x[k] = at[k].template cast<long double>();
  const auto value = [&] { return std::apply([&](const auto&... each) { return weighted(f(each...)); }, x); };
  Matrices<N> gradient;
  for (std::size_t k = 0; k < N; ++k) {
    gradient[k].resize(at[k].rows(), at[k].cols());
    for (Eigen::Index i = 0; i < x[k].size(); ++i) {
      const auto quotient = [&](long double h) { return slope_by(x[k].data()[i], h, value); };
      const long double h = 0x1p-9L, whole = quotient(h), half = quotient(h / 2), quarter = quotient(h / 4);
      const long double first = (4 * half - whole) / 3, second = (4 * quarter - half) / 3;
      gradient[k].data()[i] = static_cast<double>((16 * second - first) / 15);
    }
  }
  return gradient;
}

/// The tape's gradient, either way of holding matrices, is within `bound` of the largest entry of
/// differences.
template <class OnTape, class Reference, class... Inputs>
void check_gradient_of(const OnTape& f, const Reference& reference, double bound, const Inputs&... inputs) {
  const Matrices<sizeof...(Inputs)> at{inputs...};
  const auto expected = differences(reference, at);
  const auto entries = gradient_by_entries(f, at), arrays = gradient_by_arrays(f, at);
  for (std::size_t k = 0; k < at.size(); ++k) {
    const double scale = std::max(1.0, expected[k].cwiseAbs().maxCoeff());
    CHECK((entries[k] - expected[k]).cwiseAbs().maxCoeff() <= bound * scale);
    CHECK((arrays[k] - expected[k]).cwiseAbs().maxCoeff() <= bound * scale);
  }
}
}  // namespace tapestry::test

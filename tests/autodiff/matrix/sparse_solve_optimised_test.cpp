#include <tapestry/autodiff/detail/matrix/sparse_solve.hpp>

#include <tapestry/autodiff/matrix/solve.hpp>

#include "matrix_gradient.hpp"

namespace matrix = tapestry::matrix;
using tapestry::NumericError, tapestry::ShapeError, tapestry::Variable, tapestry::test::ActiveTape,
    tapestry::test::random_matrix, tapestry::test::weighted;

namespace {
using Dense = tapestry::test::MatrixOf<Variable<double>>;
template <class S>
using Sparse = Eigen::SparseMatrix<S>;

/// A band with two corners, whose diagonal is small, so that rows are exchanged; given in a mixed order.
std::vector<Eigen::Triplet<double>> some_entries(int n) {
  std::vector<Eigen::Triplet<double>> entries;
  for (int i = 0; i < n; ++i) {
    entries.emplace_back(i, (i + 1) % n, 2 + std::cos(i));
    entries.emplace_back(i, i, 0.1 * std::sin(3 * i + 1));
    if (i > 1) entries.emplace_back(i, i - 2, 0.5);
  }
  return entries;
}
}  // namespace

TEST_CASE("a sparse solve has the value and the gradient of the dense one", "[autodiff][matrix]") {
  constexpr int n = 12;
  ActiveTape<double> tape;
  const auto places = some_entries(n);
  std::vector<Variable<double>> inputs;
  std::vector<Eigen::Triplet<Variable<double>>> triplets;
  Dense dense = Dense::Zero(n, n);
  for (const auto& place : places) {
    inputs.push_back(tape.input(place.value()));
    triplets.emplace_back(place.row(), place.col(), inputs.back());
    dense(place.row(), place.col()) = inputs.back();
  }
  Sparse<Variable<double>> a(n, n);
  a.setFromTriplets(triplets.begin(), triplets.end());
  const Dense b = random_matrix(n, 3, 1).unaryExpr([&](double entry) { return tape.input(entry); });
  const auto gradient = [&](const Dense& x) {
    const Variable<double> root = weighted(x);
    tape.reverse(root);
    std::vector<double> all;
    for (const auto& each : inputs) all.push_back(each.adjoint());
    for (Eigen::Index i = 0; i < b.size(); ++i) all.push_back(b.data()[i].adjoint());
    return all;
  };
  const auto before = tape.record_count();
  const Dense x = matrix::solve(a, b), expected = matrix::solve(dense, b);
  CHECK(tape.record_count() == before + 2);
  for (Eigen::Index i = 0; i < x.size(); ++i)
    CHECK(std::abs(x.data()[i].value() - expected.data()[i].value()) <= 1e-14);
  const auto found = gradient(x), wanted = gradient(expected);
  for (std::size_t i = 0; i < found.size(); ++i) CHECK(std::abs(found[i] - wanted[i]) <= 1e-13);

  const Eigen::SparseMatrix<Variable<double>, Eigen::RowMajor> by_rows = a;
  const auto again = gradient(matrix::solve(by_rows, b));
  for (std::size_t i = 0; i < found.size(); ++i) CHECK(std::abs(again[i] - wanted[i]) <= 1e-13);
}

TEST_CASE("a sparse matrix of numbers solves for arrays and vectors of variables", "[autodiff][matrix]") {
  ActiveTape<double> tape;
  Sparse<double> a(2, 2);
  a.insert(0, 0) = 2;
  a.insert(1, 1) = 4;
  const auto b = tape.input(tapestry::Array<double, 1>{6.0, 8.0});
  const tapestry::ArrayVariable<double, 1> x = matrix::solve(a, b);
  tape.reverse(sum(x));
  CHECK(x.value()(1) == 2);
  CHECK(b.adjoint()(0) == 0.5);
  const Eigen::Matrix<Variable<double>, 2, 1> c(tape.input(1.0), 1.0);
  const Eigen::Matrix<Variable<double>, Eigen::Dynamic, 1> y = matrix::solve(a, c);
  tape.reverse(y(0));
  CHECK(c(0).adjoint() == 0.5);
}

TEST_CASE("singular, ill-fitting and empty sparse matrices", "[autodiff][matrix]") {
  ActiveTape<double> tape;
  const Dense b = Dense::Constant(2, 1, tape.input(1.0));
  CHECK_THROWS_WITH(matrix::solve(Sparse<double>(2, 2), b), "solve: a is singular");
  Sparse<double> equal_rows(2, 2);
  for (int i = 0; i < 2; ++i)
    for (int j = 0; j < 2; ++j) equal_rows.insert(i, j) = j + 1;
  CHECK_THROWS_AS(matrix::solve(equal_rows, b), NumericError);
  CHECK_THROWS_WITH(matrix::solve(Sparse<double>(2, 3), b), "solve: a is [2, 3], expected a square matrix");
  CHECK_THROWS_AS(matrix::solve(Sparse<double>(3, 3), b), ShapeError);
  const auto x = matrix::solve(Sparse<double>(0, 0), tape.input(tapestry::zeros<double, 2>({0, 3})));
  CHECK(x.size() == 0);
  tape.reverse(x, x.value());
}

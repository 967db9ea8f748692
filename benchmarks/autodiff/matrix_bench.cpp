// Value and gradient of solve, Cholesky and log-determinant of a positive definite matrix beside Eigen's
// plain value.
#include <benchmark/benchmark.h>

#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/autodiff/matrix/determinant.hpp>
#include <tapestry/core/random.hpp>

namespace {
using Eigen::MatrixXd, Eigen::VectorXd, tapestry::Array, tapestry::ArrayVariable, tapestry::Tape;
using tapestry::Variable;
using VariableMatrix = Eigen::Matrix<Variable<double>, Eigen::Dynamic, Eigen::Dynamic>;
namespace matrix = tapestry::matrix;

MatrixXd positive_definite(Eigen::Index n) {
  tapestry::Random random(1);
  MatrixXd a(n, n);
  for (Eigen::Index i = 0; i < a.size(); ++i) a.data()[i] = random.uniform(-1, 1);
  return a * a.transpose() + static_cast<double>(n) * MatrixXd::Identity(n, n);
}
Array<double, 2> array_of(const MatrixXd& a) {
  Array<double, 2> array(
      tapestry::Extents<2>{static_cast<std::size_t>(a.rows()), static_cast<std::size_t>(a.cols())});
  Eigen::Map<Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>>(array.data(), a.rows(),
                                                                                     a.cols()) = a;
  return array;
}

struct Solve {
  static double plain(const MatrixXd& a) { return a.partialPivLu().solve(VectorXd::Ones(a.rows())).sum(); }
  static Variable<double> on_tape(const ArrayVariable<double, 2>& a) {
    return sum(matrix::solve(a, tapestry::filled<double, 1>({a.shape()[0]}, 1.0)));
  }
  static Variable<double> on_tape(const VariableMatrix& a) {
    return matrix::solve(a, VectorXd::Ones(a.rows())).sum();
  }
};
struct Cholesky {
  static double plain(const MatrixXd& a) { return MatrixXd(a.llt().matrixL()).sum(); }
  static Variable<double> on_tape(const ArrayVariable<double, 2>& a) { return sum(matrix::cholesky(a)); }
  static Variable<double> on_tape(const VariableMatrix& a) { return matrix::cholesky(a).sum(); }
};
struct LogDeterminant {
  static double plain(const MatrixXd& a) {
    return a.partialPivLu().matrixLU().diagonal().cwiseAbs().array().log().sum();
  }
  template <class A>
  static Variable<double> on_tape(const A& a) {
    return matrix::log_determinant(a);
  }
};
struct LogDeterminantPositiveDefinite {
  static double plain(const MatrixXd& a) { return 2 * a.llt().matrixLLT().diagonal().array().log().sum(); }
  template <class A>
  static Variable<double> on_tape(const A& a) {
    return matrix::log_determinant_positive_definite(a);
  }
};

template <class Operation>
void plain_value(benchmark::State& state) {
  const MatrixXd a = positive_definite(state.range(0));
  for (auto _ : state) benchmark::DoNotOptimize(Operation::plain(a));
}

void require_equal(benchmark::State& state, double value, double expected) {
  if (!(std::abs(value - expected) <= 1e-12 * std::abs(expected))) state.SkipWithError("a wrong value");
}

template <class Operation>
void array_gradient(benchmark::State& state) {
  const MatrixXd a = positive_definite(state.range(0));
  const Array<double, 2> array = array_of(a);
  Tape<double> tape;
  const auto scope = tape.activate();
  double value = 0;
  for (auto _ : state) {
    tape.clear();
    const auto x = tape.input(array);
    const Variable<double> root = Operation::on_tape(x);
    tape.reverse(root);
    benchmark::DoNotOptimize(x.adjoint().data());
    value = root.value();
  }
  require_equal(state, value, Operation::plain(a));
}

template <class Operation>
void eigen_gradient(benchmark::State& state) {
  const MatrixXd a = positive_definite(state.range(0));
  Tape<double> tape;
  const auto scope = tape.activate();
  double value = 0;
  for (auto _ : state) {
    tape.clear();
    const VariableMatrix x = a.unaryExpr([&](double entry) { return tape.input(entry); });
    const Variable<double> root = Operation::on_tape(x);
    tape.reverse(root);
    const MatrixXd gradient = x.unaryExpr([](const Variable<double>& entry) { return entry.adjoint(); });
    benchmark::DoNotOptimize(gradient.data());
    value = root.value();
  }
  require_equal(state, value, Operation::plain(a));
}
}  // namespace

BENCHMARK_TEMPLATE(plain_value, Solve)->Arg(100);
BENCHMARK_TEMPLATE(array_gradient, Solve)->Arg(100);
BENCHMARK_TEMPLATE(eigen_gradient, Solve)->Arg(100);
BENCHMARK_TEMPLATE(plain_value, Cholesky)->Arg(100);
BENCHMARK_TEMPLATE(array_gradient, Cholesky)->Arg(100);
BENCHMARK_TEMPLATE(eigen_gradient, Cholesky)->Arg(100);
BENCHMARK_TEMPLATE(plain_value, LogDeterminant)->Arg(100);
BENCHMARK_TEMPLATE(array_gradient, LogDeterminant)->Arg(100);
BENCHMARK_TEMPLATE(eigen_gradient, LogDeterminant)->Arg(100);
BENCHMARK_TEMPLATE(plain_value, LogDeterminantPositiveDefinite)->Arg(100);
BENCHMARK_TEMPLATE(array_gradient, LogDeterminantPositiveDefinite)->Arg(100);
BENCHMARK_TEMPLATE(eigen_gradient, LogDeterminantPositiveDefinite)->Arg(100);

#include <tapestry/autodiff/implicit_function.hpp>

#include <tapestry/autodiff/matrix/solve.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"

using tapestry::implicit_function, tapestry::NumericError, tapestry::ShapeError, tapestry::Variable,
    tapestry::test::ActiveTape;

namespace {
using Variables = std::vector<Variable<double>>;
using Inputs = std::span<const Variable<double>>;

/// x³ + p x = q
Variables cubic(Inputs x, Inputs p) { return {x[0] * x[0] * x[0] + p[0] * x[0] - p[1]}; }
}  // namespace

TEST_CASE("the root of a cubic has the slopes of its closed form", "[autodiff][implicit]") {
  ActiveTape<double> tape;
  const Variables p = {tape.input(1.0), tape.input(2.0)};  // root 1
  const auto before = tape.record_count();
  const auto x = implicit_function<double>(cubic, std::array{1.0}, p);
  CHECK(tape.record_count() == before + 1);
  CHECK(x[0].value() == 1);
  const Variable<double> root = 3 * x[0] + p[0];
  tape.reverse(root);
  tape.reverse(root);                                            // repeats
  CHECK(std::abs(p[0].adjoint() - (1 - 3 * 1.0 / 4)) <= 1e-15);  // dx/dp = −x / (3 x² + p)
  CHECK(std::abs(p[1].adjoint() - 3 * 1.0 / 4) <= 1e-15);        // dx/dq = 1 / (3 x² + p)
}

TEST_CASE("a fixed point is a root of x − g(x, p)", "[autodiff][implicit]") {
  const auto solution = [](long double p) {  // x = cos(p x)
    long double x = 0.7L;
    for (int i = 0; i < 50; ++i) x -= (x - std::cos(p * x)) / (1 + p * std::sin(p * x));
    return x;
  };
  ActiveTape<double> tape;
  const Variable<double> p = tape.input(0.8);
  const auto residual = [](Inputs x, Inputs q) { return Variables{x[0] - cos(q[0] * x[0])}; };
  const auto x = implicit_function<double>(
      residual, std::array{static_cast<double>(solution(static_cast<long double>(0.8)))}, std::array{p});
  tape.reverse(x[0]);
  const long double h = 0x1p-12L, at = static_cast<long double>(0.8);
  const long double whole = (solution(at + h) - solution(at - h)) / (2 * h),
                    half = (solution(at + h / 2) - solution(at - h / 2)) / h;
  CHECK(std::abs(p.adjoint() - static_cast<double>((4 * half - whole) / 3)) <= 1e-14);
}

TEST_CASE("linear equations as an implicit function have the gradient of solve", "[autodiff][implicit]") {
  using Matrix = Eigen::Matrix<Variable<double>, Eigen::Dynamic, Eigen::Dynamic>;
  ActiveTape<double> tape;
  Variables p;
  for (int i = 0; i < 12; ++i) p.push_back(tape.input((i % 4 == 0 ? 4.0 : 0.0) + std::cos(i)));
  const auto matrix_of = [](Inputs q) {
    Matrix a(3, 3);
    for (Eigen::Index i = 0; i < 9; ++i) a(i / 3, i % 3) = q[static_cast<std::size_t>(i)];
    return a;
  };
  const Matrix side = Eigen::Map<const Matrix>(p.data() + 9, 3, 1);
  const Matrix solved = tapestry::matrix::solve(matrix_of(p), side);
  const Variable<double> expected = solved(0) + 2 * solved(1) - solved(2) * solved(2);
  tape.reverse(expected);
  std::vector<double> gradient;
  for (const auto& each : p) gradient.push_back(each.adjoint());

  const auto residual = [&](Inputs x, Inputs q) {
    const Matrix product = matrix_of(q) * Eigen::Map<const Matrix>(x.data(), 3, 1);
    return Variables{product(0) - q[9], product(1) - q[10], product(2) - q[11]};
  };
  const auto x = implicit_function<double>(
      residual, std::array{solved(0).value(), solved(1).value(), solved(2).value()}, p);
  tape.reverse(Variable<double>(x[0] + 2 * x[1] - x[2] * x[2]));
  for (std::size_t i = 0; i < 12; ++i) CHECK(std::abs(p[i].adjoint() - gradient[i]) <= 1e-15);
}

TEST_CASE("a double root has no derivative, a missing equation no place", "[autodiff][implicit]") {
  ActiveTape<double> tape;
  const Variables p = {tape.input(0.0), tape.input(0.0)};
  const auto x = implicit_function<double>(cubic, std::array{0.0}, p);
  CHECK_THROWS_AS(tape.reverse(x[0]), NumericError);
  const auto two = implicit_function<double>(cubic, std::array{0.0, 1.0}, p);
  CHECK_THROWS_WITH(tape.reverse(two[1]), "implicit_function: the residual has 1 numbers, expected 2");
  tape.reverse(Variable<double>(2 * p[0]));  // the tape stays usable, and unused results cost nothing
  CHECK(p[0].adjoint() == 2);
}

TEST_CASE("an implicit function of constants or of nothing records nothing", "[autodiff][implicit]") {
  ActiveTape<double> tape;
  CHECK_FALSE(implicit_function<double>(cubic, std::array{1.0}, Variables{1.0, 2.0})[0].is_active());
  CHECK(implicit_function<double>(cubic, std::vector<double>(), Variables{tape.input(1.0)}).empty());
  CHECK(tape.record_count() == 0);
}

TEST_CASE("a passive parameter beside an active one is a constant", "[autodiff][implicit]") {
  ActiveTape<double> tape;
  const Variables p = {1.0, tape.input(2.0)};
  tape.reverse(implicit_function<double>(cubic, std::array{1.0}, p)[0]);
  CHECK(p[1].adjoint() == 0.25);
}

#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <tapestry/autodiff.hpp>
#include <tapestry/autodiff/jacobian.hpp>
#include <tapestry/autodiff/record.hpp>
#include <vector>

#include "../support/catch.hpp"

using tapestry::AdjointVectors;
using tapestry::DomainError;
using tapestry::Tape;
using tapestry::Variable;

namespace {
/// roots[i] = x[i] · x[i + 1] − x[i] + exp(x[0]), i + 1 modulo the number of inputs.
template <class T>
std::vector<Variable<T>> roots_of(const std::vector<Variable<T>>& x) {
  std::vector<Variable<T>> roots;
  const Variable<T> first = exp(x[0]);
  for (std::size_t i = 0; i < x.size(); ++i) roots.push_back(x[i] * x[(i + 1) % x.size()] - x[i] + first);
  return roots;
}

template <class T>
std::vector<T> jacobian_by_hand(const std::vector<T>& x) {
  const std::size_t n = x.size();
  std::vector<T> rows(n * n);
  for (std::size_t i = 0; i < n; ++i) {
    rows[i * n + i] += x[(i + 1) % n] - 1;
    rows[i * n + (i + 1) % n] += x[i];
    rows[i * n] += std::exp(x[0]);
  }
  return rows;
}
}  // namespace

TEMPLATE_TEST_CASE("a Jacobian of any number of roots equals the one worked out by hand",
                   "[autodiff][jacobian]", float, double) {
  using T = TestType;
  for (const std::size_t n : {2U, 8U, 11U}) {
    std::vector<T> values(n);
    for (std::size_t i = 0; i < n; ++i) values[i] = static_cast<T>(i) / 4 + T(0.5);
    Tape<T> tape;
    const auto scope = tape.activate();
    std::vector<Variable<T>> x(n);
    tape.input(values, x);
    const auto roots = roots_of(x);
    const auto rows = tapestry::jacobian(tape, roots, x);
    const auto expected = jacobian_by_hand(values);
    REQUIRE(rows.size() == n * n);
    for (std::size_t i = 0; i < rows.size(); ++i)  // sums of three terms, each of one rounding
      CHECK(std::abs(rows[i] - expected[i]) <=
            4 * std::numeric_limits<T>::epsilon() * (1 + std::abs(expected[i])));
  }
}

TEST_CASE("a tape with pullbacks has its Jacobian root by root", "[autodiff][jacobian]") {
  Tape<double> tape;
  const auto scope = tape.activate();
  std::vector<Variable<double>> x = {tape.input(2.0), tape.input(3.0)};
  const auto cube = tapestry::record_scalar(
      8.0, [](double adjoint, double* by_x) { *by_x += 12 * adjoint; }, x[0]);
  const std::vector<Variable<double>> roots = {cube * x[1], x[1], 5.0};
  CHECK(tapestry::jacobian(tape, roots, x) == std::vector<double>{36, 8, 0, 1, 0, 0});
  AdjointVectors<double, 4> adjoints;
  CHECK_THROWS_AS(adjoints.reverse(tape, roots), DomainError);
}

TEST_CASE("in a sweep of several roots each is alone", "[autodiff][jacobian]") {
  Tape<double> tape;
  const auto scope = tape.activate();
  const Variable<double> x = tape.input(0.0);
  const Variable<double> root = sqrt(x);  // of infinite slope
  const std::vector<Variable<double>> roots = {root, x, 2 * x, Variable<double>(1.0)};
  AdjointVectors<double, 4> adjoints;
  adjoints.reverse(tape, roots);
  CHECK(adjoints.of(x) == std::array<double, 4>{std::numeric_limits<double>::infinity(), 1, 2, 0});
  CHECK(adjoints.of(root) == std::array<double, 4>{1, 0, 0, 0});
  CHECK(adjoints.of(1.0) == std::array<double, 4>{});
  adjoints.reverse(tape, std::vector{roots[1]});  // repeats, with fewer roots
  CHECK(adjoints.of(x) == std::array<double, 4>{1, 0, 0, 0});
  CHECK(adjoints.of(root) == std::array<double, 4>{});
}

TEST_CASE("adjoint vectors name what does not fit", "[autodiff][jacobian]") {
  Tape<double> tape;
  Tape<double> other;
  const auto scope = tape.activate();
  const Variable<double> x = tape.input(1.0);
  const Variable<double> stranger = other.input(1.0);
  AdjointVectors<double, 2> adjoints;
  CHECK_THROWS_AS(adjoints.of(x), DomainError);
  CHECK_THROWS_WITH(adjoints.reverse(tape, std::vector{x, x, x}),
                    "AdjointVectors: 3 roots, expected at most 2");
  CHECK_THROWS_AS(adjoints.reverse(tape, std::vector{stranger}), DomainError);
  adjoints.reverse(tape, std::vector{x});
  CHECK_THROWS_AS(adjoints.of(stranger), DomainError);
  tape.rewind(tape.mark());
  CHECK_THROWS_AS(adjoints.of(x), DomainError);
  CHECK_THROWS_AS(tapestry::jacobian(tape, std::vector{x}, std::vector{stranger}), DomainError);
}

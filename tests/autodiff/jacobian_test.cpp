#include <tapestry/autodiff.hpp>
#include <tapestry/autodiff/checkpoint.hpp>
#include <tapestry/autodiff/jacobian.hpp>
#include <tapestry/autodiff/record.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"

using tapestry::AdjointVectors, tapestry::DomainError, tapestry::Tape, tapestry::Variable,
    tapestry::test::ActiveTape;

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
    ActiveTape<T> tape;
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

TEST_CASE("a pullback is called once a root, and its inputs are in the lane of that root",
          "[autodiff][jacobian]") {
  ActiveTape<double> tape;
  std::vector<Variable<double>> x = {tape.input(2.0), tape.input(3.0)};
  int calls = 0, marks = 0;
  const auto cube = tapestry::record_scalar(
      8.0, [&](double adjoint, double* by_x) { ++calls, *by_x += 12 * adjoint; }, x[0]);
  tapestry::record_mark<double>([&] { ++marks; });
  const std::vector<Variable<double>> roots = {cube * x[1], x[1], 5.0, cube + x[0]};
  CHECK(tapestry::jacobian(tape, roots, x) == std::vector<double>{36, 8, 0, 1, 0, 0, 13, 0});
  CHECK(calls == 2);  // the others do not depend on it
  CHECK(marks == 1);
  tape.reverse(roots[0]);
  AdjointVectors<double, 4> adjoints;
  adjoints.reverse(tape, roots);
  CHECK(adjoints.of(cube) == std::array<double, 4>{3, 0, 0, 1});
  CHECK(adjoints.of(x[0]) == std::array<double, 4>{36, 0, 0, 13});
  CHECK(tape.adjoint(x[0]) == 36);  // those of reverse() stay
}

TEST_CASE("long tapes of statements and operations with many results have the Jacobian of one root a sweep",
          "[autodiff][jacobian]") {
  ActiveTape<double> tape;
  std::vector<Variable<double>> x;
  for (int i = 0; i < 5; ++i) x.push_back(tape.input(0.5 + 0.1 * i));
  std::vector<Variable<double>> state = x;
  const auto turn = [](std::span<const Variable<double>> s) {
    return roots_of(std::vector(s.begin(), s.end()));
  };
  for (int step = 0; step < 300; ++step) {  // results of each are passed long before their operation
    for (auto& each : state) each = sin(each);
    state = tapestry::checkpoint<double>(turn, state);
    for (int i = 0; i < 70; ++i) state[0] += 0.001 * tape.input(1.0) * state[1];
  }
  state.push_back(state[2] * x[3]);
  state.push_back(state[1]);  // a result is a root
  const auto rows = tapestry::jacobian(tape, state, x);
  for (std::size_t i = 0; i < state.size(); ++i) {
    tape.reverse(state[i]);
    for (std::size_t j = 0; j < x.size(); ++j) {
      const double expected = tape.adjoint(x[j]);
      CHECK(std::abs(rows[i * x.size() + j] - expected) <= 1e-12 * (1 + std::abs(expected)));
    }
  }
}

TEST_CASE("arrays have an adjoint for each root", "[autodiff][jacobian]") {
  using tapestry::Array;
  ActiveTape<double> tape;
  const Array<double, 1> start = {1.0, 2.0, 3.0};
  const auto x = tape.input(start);
  const Variable<double> scale = tape.input(2.0);
  const auto squares = tapestry::record_array<double, 1>(
      Array<double, 1>{2.0, 8.0, 18.0},
      [start](const Array<double, 1>& adjoint, Array<double, 1>* by_x, double* by_scale) {
        for (std::size_t i = 0; i < 3; ++i) {
          (*by_x)(i) += adjoint(i) * 4 * start(i);
          *by_scale += adjoint(i) * start(i) * start(i);
        }
      },
      x, scale);
  const auto pick = [&](std::size_t i) {
    return tapestry::record_scalar(
        squares.value()(i), [i](double adjoint, Array<double, 1>* array) { (*array)(i) += adjoint; },
        squares);
  };
  const std::vector<Variable<double>> roots = {pick(0) * scale, pick(2), pick(1)};
  tape.reverse(roots[2]);
  AdjointVectors<double, 4> adjoints;
  adjoints.reverse(tape, roots, std::vector{scale});
  CHECK(adjoints.of(scale) == std::array<double, 4>{1 * 2 + 2, 9, 4, 0});
  CHECK(adjoints.of(x, 0) == Array<double, 1>{8.0, 0.0, 0.0});
  CHECK(adjoints.of(x, 1) == Array<double, 1>{0.0, 0.0, 12.0});
  CHECK(adjoints.of(squares, 2) == Array<double, 1>{0.0, 1.0, 0.0});
  CHECK(adjoints.of(x, 3) == Array<double, 1>{0.0, 0.0, 0.0});  // no root
  CHECK(x.adjoint() == Array<double, 1>{0.0, 8.0, 0.0});        // of reverse()
  adjoints.reverse(tape, std::vector{roots[1]});                // forgets, and does not add
  CHECK(adjoints.of(x, 0) == Array<double, 1>{0.0, 0.0, 12.0});
  CHECK(adjoints.of(x, 1) == Array<double, 1>{0.0, 0.0, 0.0});
  CHECK(tapestry::jacobian(tape, roots, std::vector{scale}) == std::vector<double>{4, 9, 4});
  CHECK_THROWS_AS(adjoints.of(x, 4), DomainError);
  tape.clear();
  CHECK_THROWS_AS(adjoints.of(x, 0), DomainError);
}

TEST_CASE("a pullback that throws leaves a tape that can be swept", "[autodiff][jacobian]") {
  ActiveTape<double> tape;
  const auto x = tape.input(tapestry::Array<double, 1>{1.0});
  bool fails = true;
  const auto y = tapestry::record_scalar(
      1.0,
      [&](double adjoint, tapestry::Array<double, 1>* by_x) {
        if (fails) throw DomainError("on purpose");
        (*by_x)(0) += adjoint;
      },
      x);
  AdjointVectors<double, 2> adjoints;
  CHECK_THROWS_WITH(adjoints.reverse(tape, std::vector{y, y}), "on purpose");
  fails = false;
  tape.reverse(y);
  CHECK(x.adjoint()(0) == 1);
}

TEST_CASE("adjoints of arrays are those of the last sweep of several roots", "[autodiff][jacobian]") {
  ActiveTape<double> tape;
  const auto a = tape.input(tapestry::Array<double, 1>{1.0, 2.0});
  const Variable<double> x = tape.input(3.0);
  const auto sum_of_squares = tapestry::record_scalar(
      5.0,
      [](double adjoint, tapestry::Array<double, 1>* by_a) {
        (*by_a)(0) += 2 * adjoint;
        (*by_a)(1) += 4 * adjoint;
      },
      a);
  const std::vector<Variable<double>> roots{sum_of_squares, x * x};
  AdjointVectors<double, 8> first;
  first.reverse(tape, roots);
  const auto& of_sum = first.of(a, 0);
  CHECK(first.of(a, 1) == tapestry::Array<double, 1>{0.0, 0.0});  // which no pullback has reached
  CHECK(of_sum == tapestry::Array<double, 1>{2.0, 4.0});
  AdjointVectors<double, 2> second;
  second.reverse(tape, roots);
  CHECK(second.of(a, 0) == tapestry::Array<double, 1>{2.0, 4.0});
  CHECK_THROWS_WITH(first.of(a, 5), contains("those of a later sweep"));
  CHECK(first.of(x)[1] == 6);  // variables' own
}

TEST_CASE("in a sweep of several roots each is alone", "[autodiff][jacobian]") {
  ActiveTape<double> tape;
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
  Tape<double> tape, other;
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

namespace {
/// y[i] = x[i % n]² · x[(i + 1) % n] + sin(Σ x), with the sum computed once: [m] from [n].
auto curved(std::size_t m) {
  return [m](const auto& x) {
    using S = std::remove_cvref_t<decltype(x[0])>;
    S total = 0;
    for (const auto& entry : x) total += entry;
    const S shared = sin(total);
    std::vector<S> y;
    for (std::size_t i = 0; i < m; ++i)
      y.push_back(x[i % x.size()] * x[i % x.size()] * x[(i + 1) % x.size()] + shared);
    return y;
  };
}

/// The closed form, row by row; n > 1.
std::vector<double> slopes_of_curved(std::size_t m, const std::vector<double>& x) {
  const std::size_t n = x.size();
  double total = 0;
  for (const double entry : x) total += entry;
  std::vector<double> rows(m * n, std::cos(total));
  for (std::size_t i = 0; i < m; ++i) {
    rows[i * n + i % n] += 2 * x[i % n] * x[(i + 1) % n];
    rows[i * n + (i + 1) % n] += x[i % n] * x[i % n];
  }
  return rows;
}

std::vector<double> points(std::size_t n) {
  std::vector<double> x(n);
  for (std::size_t i = 0; i < n; ++i) x[i] = std::cos(static_cast<double>(2 * i + 1));
  return x;
}
}  // namespace

TEST_CASE("jacobian(f, x) equals closed form, dual numbers and central differences, whatever its shape",
          "[autodiff][jacobian]") {
  const auto [m, n] = GENERATE(table<std::size_t, std::size_t>(
      {{1, 2}, {2, 2}, {8, 8}, {30, 3}, {1, 20}, {3, 11}, {11, 11}, {12, 11}, {40, 17}}));
  INFO(m << " results of " << n << " inputs");
  const auto f = curved(m);
  const auto x = points(n);
  const auto found = tapestry::jacobian(f, x);
  REQUIRE(found.rows == m);
  REQUIRE(found.columns == n);
  REQUIRE(found.values.size() == m);
  const auto expected = slopes_of_curved(m, x);
  const auto by_duals = tapestry::forward_jacobian(f, x);
  const double h = 0x1p-17;  // truncation h²·f'''/6 and rounding ε·f/h are below 1e-10 both
  for (std::size_t j = 0; j < n; ++j) {
    auto ahead = x, behind = x;
    ahead[j] += h;
    behind[j] -= h;
    const auto far = tapestry::jacobian(f, ahead).values, near = tapestry::jacobian(f, behind).values;
    for (std::size_t i = 0; i < m; ++i) {
      CHECK(std::abs(found(i, j) - expected[i * n + j]) <= 1e-14);  // of terms up to 3
      CHECK(std::abs(found(i, j) - by_duals[i * n + j]) <= 1e-14);
      CHECK(std::abs(found(i, j) - (far[i] - near[i]) / (2 * h)) <= 1e-9);
    }
  }
}

TEST_CASE("jacobian(f, x) has a shape where there is no result or no input", "[autodiff][jacobian]") {
  const auto nothing = [](const auto& x) { return std::vector<std::remove_cvref_t<decltype(x[0])>>(); };
  for (const std::size_t n : {0U, 3U, 12U}) {
    const auto none = tapestry::jacobian(nothing, points(n));
    CHECK(none.rows == 0);
    CHECK(none.columns == n);
    CHECK((none.entries.empty() && none.values.empty()));
  }
  const auto constant = [](const auto& x) {
    using S = std::remove_cvref_t<decltype(x[0])>;
    return std::array<S, 2>{S(3), S(4)};
  };
  const auto passive = tapestry::jacobian(constant, std::vector<double>{});
  CHECK(passive.rows == 2);
  CHECK(passive.columns == 0);
  CHECK(passive.values == std::vector<double>{3, 4});
}

TEST_CASE("a passive result has a row of zeros in either direction", "[autodiff][jacobian]") {
  const auto f = [](const auto& x) {
    using S = std::remove_cvref_t<decltype(x[0])>;
    return std::vector<S>{x[0] * x[1], S(7), x[1]};
  };
  for (const std::size_t n : {2U, 9U}) {  // duals; a tape
    const auto x = points(n);
    const auto found = tapestry::jacobian(f, x);
    CHECK(found.values == std::vector<double>{x[0] * x[1], 7, x[1]});
    CHECK(found(0, 0) == x[1]);
    CHECK(found(0, 1) == x[0]);
    CHECK(found(2, 1) == 1);
    for (std::size_t j = 0; j < n; ++j) CHECK(found(1, j) == 0);
  }
}

TEST_CASE("jacobian(f, x) takes floats, numbers in braces, and functions of variables alone",
          "[autodiff][jacobian]") {
  const auto f = [](const auto& x) {
    return std::array<std::remove_cvref_t<decltype(x[0])>, 2>{x[0] * x[1], x[0] + 2 * x[1]};
  };
  CHECK(tapestry::jacobian(f, {3., 5.}).entries == std::vector<double>{5, 3, 1, 2});
  CHECK(tapestry::jacobian<float>(f, {3.F, 5.F}).entries == std::vector<float>{5, 3, 1, 2});
  const auto product = [](const auto& x) { return x[0] * x[1]; };  // one number: one row
  const auto row = tapestry::jacobian(product, {3., 5.});
  CHECK((row.rows == 1 && row.columns == 2));
  CHECK(row.entries == std::vector<double>{5, 3});
  const auto on_tape = [](std::span<const Variable<double>> x) {
    const auto pullback = [value = x[0].value()](double adjoint, double* x_adjoint) {
      *x_adjoint += adjoint * 2 * value;
    };
    const Variable<double> squared = tapestry::record_scalar(x[0].value() * x[0].value(), pullback, x[0]);
    return std::vector<Variable<double>>{squared, squared * x[1], x[1]};  // more results than inputs
  };
  CHECK(tapestry::jacobian(on_tape, {3., 5.}).entries == std::vector<double>{6, 0, 30, 9, 0, 1});
}

TEST_CASE("jacobian(f, x) refuses results whose number changes, and variables of another tape",
          "[autodiff][jacobian]") {
  int calls = 0;
  const auto growing = [&](const auto& x) {
    return std::vector<std::remove_cvref_t<decltype(x[0])>>(static_cast<std::size_t>(++calls) + 20, x[0]);
  };
  CHECK_THROWS_AS(tapestry::jacobian(growing, points(9)), DomainError);
  calls = 0;
  CHECK_THROWS_WITH(tapestry::jacobian(growing, points(9)),
                    "jacobian: 23 entries of the result in a later call, expected 22");
  Tape<double> other;
  const auto stranger = [scope = other.activate(), &other] { return other.input(1.0); }();
  const auto captures = [&](std::span<const Variable<double>>) { return std::vector{stranger}; };
  CHECK_THROWS_AS(tapestry::jacobian(captures, {1.}), DomainError);
}

#include <tapestry/autodiff.hpp>
#include <tapestry/autodiff/checkpointed_scan.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"

using tapestry::DomainError, tapestry::Tape, tapestry::Variable, tapestry::test::ActiveTape;

namespace {
using Variables = std::span<const Variable<double>>;

/// A rotation that slowly shrinks, a hundred steps of it: the state's length falls to 0.99^100 of the first.
std::vector<Variable<double>> hundred_steps(Variables state) {
  Variable<double> x = state[0], y = state[1];
  for (int i = 0; i < 100; ++i) {
    const Variable<double> turned = 0.99 * (0.8 * x - 0.6 * y);
    y = 0.99 * (0.6 * x + 0.8 * y);
    x = turned;
  }
  return {x, y};
}
}  // namespace

TEST_CASE("a checkpointed computation has the gradient of a recorded one and little tape",
          "[autodiff][segment]") {
  const auto run = [](bool checkpointed, std::vector<double>& gradient) {
    ActiveTape<double> tape;
    const std::vector<Variable<double>> start = {tape.input(1.0), tape.input(-0.5)};
    std::vector<Variable<double>> state = start;
    for (int i = 0; i < 20; ++i)
      state = checkpointed ? tapestry::checkpoint<double>(hundred_steps, state) : hundred_steps(state);
    const Variable<double> root = state[0] * state[1];
    tape.reverse(root);
    tape.reverse(root);  // repeats
    gradient = {start[0].adjoint(), start[1].adjoint()};
    return tape.statement_bytes();
  };
  std::vector<double> recorded, recomputed;
  const std::size_t recorded_bytes = run(false, recorded);
  CHECK(run(true, recomputed) < recorded_bytes / 100);
  CHECK(recomputed == recorded);
  CHECK(recorded[0] != 0);
}

TEST_CASE("results of a checkpoint that nothing depends on cost no work", "[autodiff][segment]") {
  ActiveTape<double> tape;
  const std::vector<Variable<double>> x = {tape.input(2.0), 3.0};
  int calls = 0;
  const auto products = [&calls](Variables v) {
    ++calls;
    return std::vector<Variable<double>>{v[0] * v[1], v[0] * v[0], Variable<double>(7.0)};
  };
  const auto results = tapestry::checkpoint<double>(products, x);
  CHECK(calls == 1);
  tape.reverse(Variable<double>(2 * x[0]));
  CHECK(calls == 1);
  tape.reverse(Variable<double>(results[0] + 10 * results[1] + results[2]));
  CHECK(calls == 2);
  CHECK(x[0].adjoint() == 3 + 40);
  CHECK_FALSE(tapestry::checkpoint<double>(products, std::vector<Variable<double>>{2.0, 3.0})[0].is_active());
}

TEST_CASE("the first of a checkpoint's results may be the root, whatever was swept before",
          "[autodiff][segment]") {
  ActiveTape<double> tape;
  const std::vector<Variable<double>> x = {tape.input(2.0), tape.input(3.0)};
  const auto swap = [](Variables v) { return std::vector<Variable<double>>{v[1] * 1.0, v[0] * 1.0}; };
  const auto results = tapestry::checkpoint<double>(swap, x);
  tape.reverse(Variable<double>(5 * results[1]));  // leaves an adjoint behind the next root
  tape.reverse(results[0]);
  CHECK(x[0].adjoint() == 0);
  CHECK(x[1].adjoint() == 1);
}

TEST_CASE("a preaccumulated part is one statement", "[autodiff][segment]") {
  ActiveTape<double> tape;
  const std::vector<Variable<double>> x = {tape.input(0.5), 2.0, tape.input(0.25)};
  const auto before = tape.statement_count();
  const auto part = [](Variables v) {
    Variable<double> y = v[0];
    for (int i = 0; i < 50; ++i) y = y * v[1] * v[2] + v[2];
    return y;
  };
  const Variable<double> y = tapestry::preaccumulate<double>(part, x);
  CHECK(tape.statement_count() == before + 1);
  CHECK(tape.operand_count() == 2);
  tape.reverse(y);
  const double by_first = x[0].adjoint(), by_last = x[2].adjoint();
  const Variable<double> recorded = part(x);
  tape.reverse(recorded);
  CHECK(y.value() == recorded.value());
  CHECK(by_first == x[0].adjoint());
  CHECK(std::abs(by_last - x[2].adjoint()) <= 1e-14 * std::abs(by_last));
}

TEST_CASE("segments refuse variables of another tape", "[autodiff][segment]") {
  Tape<double> tape, other;
  const auto scope = tape.activate();
  const std::vector<Variable<double>> x = {other.input(1.0), tape.input(1.0)};
  CHECK_THROWS_AS(tapestry::checkpoint<double>(hundred_steps, x), DomainError);
  CHECK_THROWS_AS(tapestry::preaccumulate<double>([](Variables v) { return v[0] * v[1]; }, x), DomainError);
  CHECK(tape.statement_count() == 1);
}

namespace {
/// Checkpoints a function of a span of variables, by checkpoint() or as a scan of one step.
template <class S, class Function>
std::vector<S> apart(bool is_scan, Function f, std::span<const S> x) {
  using T = typename S::value_type;
  if (!is_scan) return tapestry::checkpoint<T>(f, x);
  const auto step = [f](std::size_t, std::span<const S> state, std::span<const S>) { return f(state); };
  return tapestry::checkpointed_scan<T>(step, 1, x, std::vector<S>());
}
}  // namespace

TEST_CASE("second derivatives pass a checkpoint whose results have adjoint 0", "[autodiff][segment]") {
  for (const bool is_scan : {false, true}) {
    const auto squared = [is_scan]<class S>(std::span<const S> x) {  // (x² − 4)²: 12 x² − 16
      const auto rest = [](std::span<const S> v) { return std::vector<S>{v[0] * v[0] - 4}; };
      const S c = apart<S>(is_scan, rest, x)[0];
      return S(c * c);
    };
    CHECK(tapestry::hessian(squared, {2.0}) == std::vector<double>{32});
    CHECK(tapestry::hessian_product(squared, {2.0}, {0.5}).product == std::vector<double>{16});

    // a·exp(b·t) at its exact fit, a = 2, b = 1: the Hessian is 2·JᵀJ with rows (exp t, 2 t exp t).
    const auto fit = [is_scan]<class S>(std::span<const S> x) {
      const auto model = [](std::span<const S> v) {
        return std::vector<S>{v[0] * exp(0.5 * v[1]), v[0] * exp(1.0 * v[1])};
      };
      const auto y = apart<S>(is_scan, model, x);
      return S(square(y[0] - 2 * std::exp(0.5)) + square(y[1] - 2 * std::exp(1.0)));
    };
    const double e = std::exp(1.0), squares = e * e;
    const std::vector<double> expected = {2 * (e + squares), 2 * (e + 2 * squares), 2 * (e + 2 * squares),
                                          2 * (e + 4 * squares)};
    const auto found = tapestry::hessian(fit, {2.0, 1.0});
    for (std::size_t i = 0; i < 4; ++i) CHECK(std::abs(found[i] - expected[i]) <= 1e-13 * expected[i]);
  }
}

TEST_CASE("a checkpoint whose function captures an active variable is refused", "[autodiff][segment]") {
  ActiveTape<double> tape;
  const std::vector<Variable<double>> x = {tape.input(2.0)};
  const Variable<double> captured = tape.input(3.0);
  const auto product = [&](Variables v) { return std::vector<Variable<double>>{v[0] * captured}; };
  CHECK_THROWS_WITH(
      tapestry::checkpoint<double>(product, x),
      "checkpoint: the function uses an active variable beside its arguments; make it an input");
  CHECK(tape.statement_count() == 2);
}

TEST_CASE("a checkpoint whose function returns another number of variables later is refused",
          "[autodiff][segment]") {
  ActiveTape<double> tape;
  const std::vector<Variable<double>> x = {tape.input(2.0)};
  std::size_t count = 2;
  const auto growing = [&count](Variables v) { return std::vector<Variable<double>>(count, v[0] * 2.0); };
  const auto results = tapestry::checkpoint<double>(growing, x);
  count = 3;
  CHECK_THROWS_WITH(tape.reverse(results[0]),
                    "checkpoint: the function returned 3 variables, and 2 when first called");
}

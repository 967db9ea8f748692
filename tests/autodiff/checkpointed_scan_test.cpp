#include <tapestry/autodiff/checkpointed_scan.hpp>

#include <tapestry/autodiff/functions.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"

using tapestry::checkpointed_scan, tapestry::ShapeError, tapestry::Variable, tapestry::test::ActiveTape;

namespace {
using Variables = std::vector<Variable<double>>;
using Inputs = std::span<const Variable<double>>;

/// A driven pendulum with damping; the last number is a sum on the way.
Variables pendulum(std::size_t index, Inputs state, Inputs parameters) {
  const Variable<double> force = sin(state[0]) * parameters[0] + parameters[1] * state[1];
  const Variable<double> speed = state[1] - 0.05 * force + 0.01 * std::cos(0.1 * static_cast<double>(index));
  const Variable<double> angle = state[0] + 0.05 * speed * parameters[0];
  return {angle, speed, state[2] + 0.05 * angle * angle};
}

Variables plain(std::size_t step_count, const Variables& initial, const Variables& parameters) {
  Variables state = initial;
  for (std::size_t i = 0; i < step_count; ++i) state = pendulum(i, state, parameters);
  return state;
}

/// The gradient of a function of the last state, of the initial one and of the parameters.
template <class Run>
std::vector<double> gradient_of(const Run& run) {
  ActiveTape<double> tape;
  const Variables initial = {tape.input(0.5), tape.input(-0.25), 0.0};
  const Variables parameters = {tape.input(1.5), tape.input(0.125)};
  const Variables last = run(initial, parameters);
  const Variable<double> root =
      last[0] * last[1] + exp(-last[2]) * parameters[0] + initial[0] / 3 + parameters[1] / 7;
  tape.reverse(root);
  tape.reverse(root);  // repeats
  return {root.value(), initial[0].adjoint(), initial[1].adjoint(), parameters[0].adjoint(),
          parameters[1].adjoint()};
}

/// How often a scan of n steps calls its step: once forwards, then again backwards.
std::size_t count_calls(std::size_t step_count, std::size_t most_states) {
  std::size_t calls = 0;
  const auto step = [&calls](std::size_t, Inputs state, Inputs) {
    ++calls;
    return Variables{state[0] * 1.0};
  };
  ActiveTape<double> tape;
  const Variables initial = {tape.input(1.0)};
  tape.reverse(checkpointed_scan<double>(step, step_count, initial, Variables(), most_states)[0]);
  CHECK(initial[0].adjoint() == 1);
  return calls;
}
}  // namespace

TEST_CASE("a checkpointed scan has the bits of the plain tape, however few states it keeps",
          "[autodiff][scan][repeated]") {
  for (const std::size_t step_count : {0U, 1U, 2U, 3U, 7U, 100U, 641U}) {
    const auto expected =
        gradient_of([&](const Variables& x, const Variables& p) { return plain(step_count, x, p); });
    for (const std::size_t most_states : {0U, 2U, 3U, 4U, 9U, 100U, 1000U})
      CHECK(gradient_of([&](const Variables& x, const Variables& p) {
              return checkpointed_scan<double>(pendulum, step_count, x, p, most_states);
            }) == expected);
  }
}

TEST_CASE("steps are computed again as often as the binomial bound says", "[autodiff][scan]") {
  CHECK(count_calls(1, 100) == 2);
  CHECK(count_calls(99, 100) == 99 + 98 + 99);  // all states are kept: forwards, once more, recorded
  CHECK(count_calls(10, 2) == 10 + 9 * 10 / 2 + 10);
  // Ten steps of (3 + 2)! / (3! 2!) with three kept and at most two repeats: 2 · 10 − (3 + 2)! / (4! 1!)
  // = 15.
  CHECK(count_calls(10, 4) == 10 + 15 + 10);
}

TEST_CASE("a scan leaves little on the tape and keeps few states", "[autodiff][scan]") {
  ActiveTape<double> tape;
  const Variables initial = {tape.input(0.5), tape.input(-0.25), 0.0};
  const auto before = tape.statement_count();
  const auto last = checkpointed_scan<double>(pendulum, 10000, initial, Variables{1.5, 0.125});
  CHECK(tape.statement_count() == before + 1 + 3);
  CHECK(tape.record_count() == 1);
  CHECK(last[2].is_active());
}

TEST_CASE("a scan that keeps every one of many states needs no deep stack", "[autodiff][scan]") {
  const auto half = [](std::size_t, Inputs x, Inputs) { return Variables{x[0] * 0.5 + 1.0}; };
  ActiveTape<double> tape;
  const Variable<double> x = tape.input(3.0);
  const std::size_t steps = 200000;
  const auto last = checkpointed_scan<double>(half, steps, Variables{x}, Variables(), steps);
  tape.reverse(last[0]);
  CHECK(last[0].value() == 2);
  CHECK(x.adjoint() == 0);
}

TEST_CASE("a scan of constants records nothing, one of one variable twice adds both", "[autodiff][scan]") {
  ActiveTape<double> tape;
  const auto frozen = checkpointed_scan<double>(pendulum, 5, Variables{0.5, 0.25, 0.0}, Variables{1.5, 0.5});
  CHECK_FALSE(frozen[0].is_active());
  CHECK(tape.statement_count() == 0);
  const auto product = [](std::size_t, Inputs x, Inputs p) { return Variables{x[0] * p[0], x[1] * p[1]}; };
  const Variable<double> x = tape.input(3.0);
  const auto last = checkpointed_scan<double>(product, 2, Variables{x, x}, Variables{x, x});
  tape.reverse(Variable<double>(last[0] + last[1]));  // 2 x³
  CHECK(x.adjoint() == 6 * 9);
}

TEST_CASE("the first number of a scan's last state may be the root", "[autodiff][scan]") {
  ActiveTape<double> tape;
  const Variables x = {tape.input(2.0), tape.input(3.0)};
  const auto swap = [](std::size_t, Inputs v, Inputs) { return Variables{v[1] * 1.0, v[0] * 1.0}; };
  const auto last = checkpointed_scan<double>(swap, 3, x, Variables());
  tape.reverse(Variable<double>(5 * last[1]));
  tape.reverse(last[0]);
  CHECK(x[0].adjoint() == 0);
  CHECK(x[1].adjoint() == 1);
}

TEST_CASE("a scan whose step changes the state's size is refused", "[autodiff][scan]") {
  ActiveTape<double> tape;
  const auto growing = [](std::size_t, Inputs x, Inputs) { return Variables{x[0], x[0]}; };
  CHECK_THROWS_WITH(checkpointed_scan<double>(growing, 2, Variables{tape.input(1.0)}, Variables()),
                    "checkpointed_scan: step 0 makes 2 variables of 1");
  CHECK(checkpointed_scan<double>(growing, 0, Variables{2.0}, Variables()).size() == 1);
}

TEST_CASE("a scan whose step captures an active variable is refused, and leaves nothing on the tape",
          "[autodiff][scan]") {
  ActiveTape<double> tape;
  const Variable<double> x = tape.input(2.0), captured = tape.input(3.0);
  const auto step = [&](std::size_t i, Inputs v, Inputs) {
    return Variables{i < 2 ? Variable<double>(v[0] * 2.0) : Variable<double>(v[0] * captured)};
  };
  const auto before = tape.statement_count();
  CHECK_THROWS_WITH(
      checkpointed_scan<double>(step, 4, Variables{x}, Variables()),
      "checkpointed_scan: step 2 uses an active variable beside its arguments; make it a parameter");
  CHECK(tape.statement_count() == before);
  CHECK(checkpointed_scan<double>(step, 2, Variables{x}, Variables())[0].value() == 8);
}

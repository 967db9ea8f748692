// A million steps of a pendulum: the plain tape beside a scan that keeps a hundred states.
#include <benchmark/benchmark.h>

#include <tapestry/autodiff/checkpointed_scan.hpp>
#include <tapestry/autodiff/functions.hpp>

namespace {
using tapestry::Tape, tapestry::Variable;
using Variables = std::vector<Variable<double>>;
using Inputs = std::span<const Variable<double>>;

/// Four steps of Euler's method, the sine by a product, for what is to be seen is the tape.
Variables step(std::size_t, Inputs state, Inputs parameters) {
  Variable<double> angle = state[0], speed = state[1];
  for (int i = 0; i < 4; ++i) {
    speed = speed - 0.001 * (parameters[0] * angle * (1 - angle * angle / 6) + parameters[1] * speed);
    angle = angle + 0.001 * speed;
  }
  return {angle, speed};
}

double gradient(Tape<double>& tape, std::size_t step_count, std::size_t most_states) {
  tape.clear();
  const auto scope = tape.activate();
  const Variables parameters = {tape.input(1.5), tape.input(1e-4)};
  Variables state = {tape.input(0.5), tape.input(0.0)};
  if (most_states > 0)
    state = tapestry::checkpointed_scan<double>(step, step_count, state, parameters, most_states);
  else
    for (std::size_t i = 0; i < step_count; ++i) state = step(i, state, parameters);
  tape.reverse(state[0]);
  return parameters[0].adjoint();
}

/// \param state  the number of steps, and of states to keep; none for a plain recording
void steps(benchmark::State& state) {
  Tape<double> tape, other;
  const auto step_count = static_cast<std::size_t>(state.range(0));
  const auto most_states = static_cast<std::size_t>(state.range(1));
  double found = 0;
  for (auto _ : state) benchmark::DoNotOptimize(found = gradient(tape, step_count, most_states));
  if (found != gradient(other, step_count, 0)) state.SkipWithError("other bits than the plain tape");
}
}  // namespace

BENCHMARK(steps)->Args({1000000, 0})->Args({1000000, 100})->Unit(benchmark::kMillisecond);

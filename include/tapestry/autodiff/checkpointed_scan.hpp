#pragma once
#include <tapestry/autodiff/checkpoint.hpp>

namespace tapestry {
namespace detail {
/// Number of steps that can be reversed with `snapshots` states kept, each step computed at most `repeats`
/// times beforehand: (snapshots + repeats)! / (snapshots! repeats!), or `enough` if that is less.
[[nodiscard]] inline std::size_t reversible_steps(std::size_t snapshots, std::size_t repeats,
                                                  std::size_t enough) {
  std::size_t count = 1;
  for (std::size_t i = 1; i <= repeats; ++i) {
    if (count / i > enough / (snapshots + i)) return enough;  // the product might overflow
    count = count * (snapshots + i) / i;
    if (count >= enough) return enough;
  }
  return count;
}

/// Steps, of `steps` ≥ 2, up to the next state to keep, so that the fewest are computed again; `snapshots` ≥
/// 2 states may be kept, the first included. Source: Griewank and Walther 2000, "Algorithm 799: revolve".
[[nodiscard]] inline std::size_t steps_to_next_snapshot(std::size_t steps, std::size_t snapshots) {
  std::size_t repeats = 1;
  while (reversible_steps(snapshots, repeats, steps) < steps) ++repeats;
  return std::min(reversible_steps(snapshots, repeats - 1, steps),
                  steps - std::min(steps - 1, reversible_steps(snapshots - 1, repeats - 1, steps)));
}

template <class T, class Step>
[[nodiscard]] std::vector<Variable<T>> checked_step(const Step& step, std::size_t index,
                                                    std::span<const Variable<T>> state,
                                                    std::span<const Variable<T>> parameters) {
  std::vector<Variable<T>> next = step(index, state, parameters);
  if (next.size() != state.size())
    throw ShapeError(
        {"checkpointed_scan: step ", index, " makes ", next.size(), " variables of ", state.size()});
  return next;
}

/// The state behind all steps. \throws DomainError if a step makes an active one of constants
template <class T, class Step>
[[nodiscard]] std::vector<Variable<T>> last_state(const Step& step, std::size_t step_count,
                                                  std::span<const Variable<T>> initial,
                                                  std::span<const Variable<T>> parameters) {
  std::vector<Variable<T>> state = passive_copies(initial);
  const std::vector<Variable<T>> constants = passive_copies(parameters);
  const PassiveOnly<T> check;
  for (std::size_t i = 0; i < step_count; ++i) {
    state = checked_step<T>(step, i, state, constants);
    if (any_active<T>(state)) check.refuse("checkpointed_scan: step " + std::to_string(i), "a parameter");
  }
  return state;
}

/// One reverse sweep through all steps.
template <class T, class Step>
class ScanSweep {
 public:
  /// \param inputs          the first state, then the parameters
  /// \param adjoints        of the last state; replaced by those of the first
  /// \param input_adjoints  are added to
  ScanSweep(const Step& step, std::span<const Variable<T>> inputs, std::span<const T> adjoints,
            std::span<T> input_adjoints)
      : step_(step),
        parameters_(inputs.subspan(adjoints.size())),
        adjoints_(adjoints.begin(), adjoints.end()),
        input_adjoints_(input_adjoints),
        constants_(passive_copies(parameters_)) {}

  /// Steps [begin, end) backwards. \param state  at begin; keeps at most `snapshots` states with this one
  void run(std::vector<T> state, std::size_t begin, std::size_t end, std::size_t snapshots) {
    std::vector<Segment> open{{std::move(state), begin, end, snapshots}};  // those behind others first
    while (!open.empty()) {
      Segment& last = open.back();
      const std::size_t steps = last.end - last.begin;
      if (steps == 1) {
        pull_back(last.state, last.begin);
        open.pop_back();
        continue;
      }
      const std::size_t middle =
          last.snapshots > 1 ? last.begin + steps_to_next_snapshot(steps, last.snapshots) : last.end - 1;
      Segment rest{advanced(last.state, last.begin, middle), middle, last.end,
                   std::max<std::size_t>(last.snapshots, 2) - 1};
      last.end = middle;
      open.push_back(std::move(rest));
    }
  }

 private:
  /// Steps [begin, end), and the state at begin.
  struct Segment {
    std::vector<T> state;
    std::size_t begin, end, snapshots;
  };

  [[nodiscard]] std::vector<T> advanced(const std::vector<T>& state, std::size_t begin,
                                        std::size_t end) const {
    std::vector<Variable<T>> moving(state.begin(), state.end());
    for (std::size_t i = begin; i < end; ++i) moving = checked_step<T>(step_, i, moving, constants_);
    std::vector<T> values;
    values.reserve(moving.size());
    for (const Variable<T>& variable : moving) values.push_back(variable.value());
    return values;
  }

  void pull_back(const std::vector<T>& state, std::size_t index) {
    tape_->clear();
    const auto scope = tape_->activate();
    std::vector<Variable<T>> inputs(state.size());
    tape_->input(state, inputs);
    for (const Variable<T>& parameter : parameters_)
      inputs.push_back(parameter.is_active() ? tape_->input(parameter.value()) : parameter);
    const std::span<const Variable<T>> all(inputs);
    const auto next = checked_step<T>(step_, index, all.first(state.size()), all.subspan(state.size()));
    std::vector<T> apart(state.size());
    const auto exchange_first = [&] {
      if (index > 0) std::swap_ranges(apart.begin(), apart.end(), input_adjoints_.begin());
    };
    exchange_first();  // input_adjoints_ serves this state meanwhile
    sweep_results<T>(*tape_, next, adjoints_, all, input_adjoints_);
    exchange_first();
    adjoints_ = std::move(apart);
  }

  const Step& step_;
  std::span<const Variable<T>> parameters_;
  std::vector<T> adjoints_;
  std::span<T> input_adjoints_;
  std::vector<Variable<T>> constants_;
  SpareTape<T> tape_;
};

/// The part that is many steps.
template <class T, class Step>
struct ScanPart {
  Step step;
  std::size_t step_count, snapshots;

  /// \param inputs  the first state, of as many numbers as the last one, then the parameters
  void operator()(std::span<const Variable<T>> inputs, std::span<const T> result_adjoints,
                  std::span<T> input_adjoints) const {
    std::vector<T> state;
    for (const Variable<T>& variable : inputs.first(result_adjoints.size()))
      state.push_back(variable.value());
    ScanSweep<T, Step>(step, inputs, result_adjoints, input_adjoints).run(state, 0, step_count, snapshots);
  }
};
}  // namespace detail

/// The state after many steps, state[i + 1] = step(i, state[i], parameters). Nothing is recorded: a reverse
/// sweep computes the steps again from a few states that it keeps, and records one step at a time. Memory:
/// those states and the tape of one step. With s states and r such that step_count ≤ (s + r)! / (s! r!), each
/// step is computed at most r + 2 times and recorded once: 4 + 2 times for a million steps and 100 states.
/// Source: Griewank and Walther 2000, "Algorithm 799: revolve". Gradients have the bits of a plain recording,
/// unless a step returns one variable twice, or a parameter as the state.
///
///   const auto step = [](std::size_t, auto state, auto parameters) {       // of a damped oscillator
///     const Variable<double> v = state[1] - 0.01 * (parameters[0] * state[0] + parameters[1] * state[1]);
///     return std::vector<Variable<double>>{state[0] + 0.01 * v, v};
///   };
///   const auto last = checkpointed_scan<double>(step, 1'000'000, initial, parameters);
///
/// \param step        takes the step's index and two std::span<const Variable<T>>, state and parameters, and
///                    returns std::vector<Variable<T>> of the state's size; computes the same in each call,
///                    uses no other active variables, and is copied
/// \param step_count  number of steps; 0 leaves the state unchanged
/// \param initial     the first state, active or passive
/// \param parameters  variables that all steps use, active or passive
/// \param most_states number of states kept at once, with the one being computed; at least 2. With 2 the work
///                    is quadratic
/// \returns           the last state; passive, with nothing recorded, if all of initial and parameters are
/// \throws DomainError as any statement, and if a step uses other active variables; ShapeError if a step
///         changes the state's size
template <class T, class Step>
[[nodiscard]] std::vector<Variable<T>> checkpointed_scan(Step step, std::size_t step_count,
                                                         std::span<const Variable<T>> initial,
                                                         std::span<const Variable<T>> parameters,
                                                         std::size_t most_states = 100) {
  if (step_count == 0) return {initial.begin(), initial.end()};
  std::vector<Variable<T>> state = detail::last_state<T>(step, step_count, initial, parameters);
  std::vector<Variable<T>> inputs(initial.begin(), initial.end());
  inputs.insert(inputs.end(), parameters.begin(), parameters.end());
  return detail::record_checkpoint<T>(
      detail::ScanPart<T, Step>{std::move(step), step_count, std::max<std::size_t>(most_states, 2) - 1},
      std::move(inputs), std::move(state));
}
}  // namespace tapestry

#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <tapestry/autodiff/checkpoint.hpp>
#include <tapestry/autodiff/tape.hpp>
#include <tapestry/autodiff/tape/spare_tape.hpp>
#include <tapestry/autodiff/variable.hpp>
#include <tapestry/core/error.hpp>
#include <utility>
#include <vector>

namespace tapestry {
namespace detail {

/// How many steps can be reversed with `snapshots` states kept, each step computed at most `repeats` times
/// beforehand: (snapshots + repeats)! / (snapshots! repeats!), or `enough` if that is less.
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

/// Number of steps, of `steps` ≥ 2, after which to keep the next state, where `snapshots` ≥ 2 may be kept
/// with the first, so that the fewest steps are computed again. Source: Griewank and Walther 2000, "Algorithm
/// 799: revolve".
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
    throw ShapeError("checkpointed_scan: step " + std::to_string(index) + " makes " +
                     std::to_string(next.size()) + " variables of " + std::to_string(state.size()));
  return next;
}

template <class T>
[[nodiscard]] std::vector<Variable<T>> passive_copies(std::span<const Variable<T>> variables) {
  std::vector<Variable<T>> copies;
  for (const Variable<T>& variable : variables) copies.push_back(passive(variable));
  return copies;
}

/// The state behind all steps. \throws DomainError if a step makes an active one of constants
template <class T, class Step>
[[nodiscard]] std::vector<Variable<T>> last_state(const Step& step, std::size_t step_count,
                                                  std::span<const Variable<T>> initial,
                                                  std::span<const Variable<T>> parameters) {
  std::vector<Variable<T>> state = passive_copies(initial);
  const std::vector<Variable<T>> constants = passive_copies(parameters);
  TapeState<T>* const tape = TapeState<T>::is_any_active() ? &TapeState<T>::require_active() : nullptr;
  const TapePosition before = tape == nullptr ? TapePosition() : tape->mark();
  const auto is_active = [](const Variable<T>& variable) { return variable.is_active(); };
  for (std::size_t i = 0; i < step_count; ++i) {
    state = checked_step<T>(step, i, state, constants);
    if (std::none_of(state.begin(), state.end(), is_active)) continue;
    if (tape != nullptr) tape->rewind(before);
    throw DomainError("checkpointed_scan: step " + std::to_string(i) +
                      " uses an active variable beside its arguments; make it a parameter");
  }
  return state;
}

template <class T>
void add_adjoints(T* adjoints, std::span<const Variable<T>> variables, std::span<const T> parts) {
  for (std::size_t i = 0; i < parts.size(); ++i)
    if (variables[i].is_active()) adjoints[variables[i].link().index()] += parts[i];
}

/// One reverse sweep through all steps.
template <class T, class Step>
class ScanSweep {
 public:
  /// The adjoints of the last state become those of the first. The adjoints of the first state and of the
  /// parameters start from their present values, and are added to in the order of statements, as on one tape:
  /// with its bits.
  struct Adjoints {
    std::vector<T> initial, state, parameters;
  };

  ScanSweep(const Step& step, std::span<const Variable<T>> parameters, Adjoints& adjoints)
      : step_(step), parameters_(parameters), adjoints_(adjoints), constants_(passive_copies(parameters)) {}

  /// Steps [begin, end) backwards. \param state  at begin; `snapshots` may be kept, this one included
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
    std::vector<Variable<T>> inputs(state.size()), parameters;
    tape_->input(state, inputs);
    for (const Variable<T>& parameter : parameters_)
      parameters.push_back(parameter.is_active() ? tape_->input(parameter.value()) : parameter);
    const auto next = checked_step<T>(step_, index, inputs, parameters);
    for (const Variable<T>& variable : next) tape_->shared_state()->require_own_if_active(variable.link());
    tape_->shared_state()->reverse(tape_->statement_count(), [&](T* adjoints) {
      if (index == 0) add_adjoints<T>(adjoints, inputs, adjoints_.initial);
      add_adjoints<T>(adjoints, parameters, adjoints_.parameters);
      add_adjoints<T>(adjoints, next, adjoints_.state);
    });
    tape_->adjoints(inputs, adjoints_.state);
    tape_->adjoints(parameters, adjoints_.parameters);
  }

  const Step& step_;
  std::span<const Variable<T>> parameters_;
  Adjoints& adjoints_;
  std::vector<Variable<T>> constants_;
  SpareTape<T> tape_;
};

/// Many steps that are not recorded. The last state is the statements behind it.
template <class T, class Step>
class ScanRecord final : public TapeRecord<T> {
 public:
  ScanRecord(Step step, std::size_t step_count, std::span<const Variable<T>> initial,
             std::span<const Variable<T>> parameters, std::size_t snapshots)
      : step_(std::move(step)),
        step_count_(step_count),
        initial_(initial.begin(), initial.end()),
        parameters_(parameters.begin(), parameters.end()),
        snapshots_(snapshots) {}

  void pull_back(T* adjoints, std::size_t statement) override {
    const T* const results = adjoints + statement + 1;
    typename ScanSweep<T, Step>::Adjoints parts;
    parts.state.assign(results, results + initial_.size());
    if (std::all_of(parts.state.begin(), parts.state.end(), [](const T& x) { return is_zero(x); })) return;
    parts.initial = taken(adjoints, initial_);
    parts.parameters = taken(adjoints, parameters_);
    std::vector<T> state;
    for (const Variable<T>& variable : initial_) state.push_back(variable.value());
    ScanSweep<T, Step>(step_, parameters_, parts).run(state, 0, step_count_, snapshots_);
    add_adjoints<T>(adjoints, initial_, parts.state);
    add_adjoints<T>(adjoints, parameters_, parts.parameters);
  }
  void list_inputs(std::vector<std::uint32_t>& statements) const override {
    list_variables<T>(initial_, statements);
    list_variables<T>(parameters_, statements);
  }

 private:
  /// Returns the adjoints of variables and sets them to zero; of a variable that stands there twice, once.
  static std::vector<T> taken(T* adjoints, const std::vector<Variable<T>>& variables) {
    std::vector<T> found;
    for (const Variable<T>& variable : variables)
      found.push_back(variable.is_active() ? std::exchange(adjoints[variable.link().index()], T(0)) : T(0));
    return found;
  }

  Step step_;
  std::size_t step_count_;
  std::vector<Variable<T>> initial_, parameters_;
  std::size_t snapshots_;
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
/// \param step_count  number of steps; the state stays as it is for 0
/// \param initial     the first state, active or passive
/// \param parameters  variables that all steps use, active or passive
/// \param most_states number of states kept at once, the one being computed included; at least 2 are. With 2
///                    the work is quadratic
/// \returns           the last state; passive, with nothing recorded, if all of initial and parameters are
/// \throws DomainError as any statement, and if a step uses other active variables; ShapeError if a step
///         changes the state's size
template <class T, class Step>
[[nodiscard]] std::vector<Variable<T>> checkpointed_scan(Step step, std::size_t step_count,
                                                         std::span<const Variable<T>> initial,
                                                         std::span<const Variable<T>> parameters,
                                                         std::size_t most_states = 100) {
  const auto is_active = [](const Variable<T>& variable) { return variable.is_active(); };
  const bool any_active = std::any_of(initial.begin(), initial.end(), is_active) ||
                          std::any_of(parameters.begin(), parameters.end(), is_active);
  if (step_count == 0) return {initial.begin(), initial.end()};
  std::vector<Variable<T>> state = detail::last_state<T>(step, step_count, initial, parameters);
  if (!any_active || state.empty()) return state;
  auto& tape = detail::TapeState<T>::require_active();
  for (const auto& from : {initial, parameters})
    for (const Variable<T>& variable : from) tape.require_own_if_active(variable.link());
  using Record = detail::ScanRecord<T, Step>;
  static_cast<void>(
      tape.append_record(std::make_unique<Record>(std::move(step), step_count, initial, parameters,
                                                  std::max<std::size_t>(most_states, 2) - 1),
                         state.size()));
  for (Variable<T>& variable : state) variable = {variable.value(), tape.append_input()};
  return state;
}

}  // namespace tapestry

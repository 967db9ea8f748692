#pragma once
#include <cstddef>
#include <cstdint>
#include <memory>
#include <span>
#include <tapestry/autodiff/tape.hpp>
#include <tapestry/autodiff/tape/spare_tape.hpp>
#include <tapestry/autodiff/variable.hpp>
#include <utility>
#include <vector>

namespace tapestry {
namespace detail {

/// d roots · seeds / d inputs of a function, from a tape of its own.
/// \returns the values of the roots
template <class T, class Function, class Seeds>
std::vector<T> differentiate_apart(const Function& function, std::span<const T> inputs, Seeds seeds_of,
                                   std::span<T> input_adjoints) {
  SpareTape<T> tape;
  const auto scope = tape->activate();
  const std::span<const Variable<T>> variables = tape.input(inputs);
  const std::vector<Variable<T>> roots = function(variables);
  std::vector<T> values;
  for (const Variable<T>& root : roots) values.push_back(root.value());
  const std::vector<T> seeds = seeds_of(roots.size());
  tape->reverse(record_partials<T>(T(0), roots, seeds));
  tape->adjoints(variables, input_adjoints);
  return values;
}

template <class T>
[[nodiscard]] std::vector<T> values_of(std::span<const Variable<T>> variables) {
  std::vector<T> values;
  for (const Variable<T>& variable : variables) values.push_back(variable.value());
  return values;
}

/// Appends the statements of the active variables.
template <class T>
void list_variables(std::span<const Variable<T>> variables, std::vector<std::uint32_t>& statements) {
  for (const Variable<T>& variable : variables)
    if (variable.is_active()) statements.push_back(variable.link().index());
}

/// A part of the computation that is not recorded; the sweep computes it again, on a tape of its own. Its
/// results are the statements behind it.
template <class T, class Function>
class CheckpointRecord final : public TapeRecord<T> {
 public:
  CheckpointRecord(Function function, std::span<const Variable<T>> inputs, std::size_t result_count)
      : function_(std::move(function)), inputs_(inputs.begin(), inputs.end()), result_count_(result_count) {}
  void pull_back(T* adjoints, std::size_t statement) override {
    const T* const results = adjoints + statement + 1;
    bool is_zero = true;
    for (std::size_t i = 0; i < result_count_; ++i) is_zero = is_zero && results[i] == T(0);
    if (is_zero) return;
    std::vector<T> input_adjoints(inputs_.size());
    differentiate_apart<T>(
        function_, values_of<T>(inputs_),
        [&](std::size_t) { return std::vector<T>(results, results + result_count_); },
        std::span<T>(input_adjoints));
    for (std::size_t i = 0; i < inputs_.size(); ++i)
      if (inputs_[i].is_active()) adjoints[inputs_[i].link().index()] += input_adjoints[i];
  }
  void list_inputs(std::vector<std::uint32_t>& statements) const override {
    list_variables<T>(inputs_, statements);
  }

 private:
  Function function_;
  std::vector<Variable<T>> inputs_;
  std::size_t result_count_;
};
}  // namespace detail

/// Computes a function of several variables and records it as one statement, whose gradient is taken at once:
/// for parts with many operations and few inputs. The tape keeps nothing else of them.
/// \param function  takes std::span<const Variable<T>> of as many, and returns a Variable<T>; uses no other
///                  active ones
template <class T, class Function>
[[nodiscard]] Variable<T> preaccumulate(const Function& function, std::span<const Variable<T>> inputs) {
  std::vector<T> partials(inputs.size());
  const auto values = detail::differentiate_apart<T>(
      [&](std::span<const Variable<T>> x) { return std::vector<Variable<T>>{function(x)}; },
      detail::values_of<T>(inputs), [](std::size_t) { return std::vector<T>{T(1)}; }, std::span<T>(partials));
  return record_partials<T>(values.front(), inputs, partials);
}

/// Computes a function of several variables without recording it; every reverse() computes it again, on a
/// tape of its own. A long computation in n such pieces needs the tape of one of them at a time, and twice
/// the work.
/// \param function  takes std::span<const Variable<T>> of as many, and returns std::vector<Variable<T>>; it
///                  computes the same whenever called, uses no other active variables, and is copied
/// \throws DomainError as any statement; nothing is recorded if all inputs are passive
template <class T, class Function>
[[nodiscard]] std::vector<Variable<T>> checkpoint(Function function, std::span<const Variable<T>> inputs) {
  std::vector<Variable<T>> passive_inputs;
  bool is_active = false;
  for (const Variable<T>& input : inputs) {
    passive_inputs.push_back(passive(input));
    is_active = is_active || input.is_active();
  }
  std::vector<Variable<T>> results = function(std::span<const Variable<T>>(passive_inputs));
  if (!is_active) return results;
  auto& state = detail::TapeState<T>::require_active();
  for (const Variable<T>& input : inputs) state.require_own_if_active(input.link());
  using Record = detail::CheckpointRecord<T, Function>;
  static_cast<void>(state.append_record(std::make_unique<Record>(std::move(function), inputs, results.size()),
                                        results.size()));
  for (Variable<T>& result : results) result = {result.value(), state.append_input()};
  return results;
}

}  // namespace tapestry

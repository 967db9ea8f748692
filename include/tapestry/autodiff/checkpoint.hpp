#pragma once
#include <algorithm>
#include <tapestry/autodiff/detail/tape/spare_tape.hpp>

namespace tapestry {
namespace detail {
template <class T>
[[nodiscard]] std::vector<Variable<T>> passive_copies(std::span<const Variable<T>> variables) {
  std::vector<Variable<T>> copies;
  for (const Variable<T>& variable : variables) copies.push_back(passive(variable));
  return copies;
}

template <class T>
[[nodiscard]] bool any_active(std::span<const Variable<T>> variables) {
  return std::any_of(variables.begin(), variables.end(),
                     [](const Variable<T>& variable) { return variable.is_active(); });
}

/// Appends the statements of the active variables.
template <class T>
void list_variables(std::span<const Variable<T>> variables, std::vector<std::uint32_t>& statements) {
  for (const Variable<T>& variable : variables)
    if (variable.is_active()) statements.push_back(variable.link().index());
}

template <class T>
void add_adjoints(T* adjoints, std::span<const Variable<T>> variables, std::span<const T> parts) {
  for (std::size_t i = 0; i < parts.size(); ++i)
    if (variables[i].is_active()) adjoints[variables[i].link().index()] += parts[i];
}

/// A computation from passive variables; refuses the use of an active one.
template <class T>
class PassiveOnly {
 public:
  PassiveOnly() {
    if (!TapeState<T>::is_any_active()) return;
    tape_ = &TapeState<T>::require_active();
    before_ = tape_->mark();
  }
  /// Forgets what was recorded since this was made.
  [[noreturn]] void refuse(const std::string& what, const char* remedy) const {
    if (tape_ != nullptr) tape_->rewind(before_);
    throw DomainError({what, " uses an active variable beside its arguments; make it ", remedy});
  }

 private:
  TapeState<T>* tape_ = nullptr;
  TapePosition before_;
};

/// Sweeps the active tape, which is `tape`, back from the results of a function recorded on it. Starts from
/// the inputs' present adjoints and adds to them in the order of statements: the bits are those of the
/// function recorded behind the statements that gave these.
/// \throws DomainError if a result is on another tape, or the numbers of results and adjoints differ
template <class T>
void sweep_results(Tape<T>& tape, std::span<const Variable<T>> results, std::span<const T> result_adjoints,
                   std::span<const Variable<T>> inputs, std::span<T> input_adjoints) {
  if (results.size() != result_adjoints.size())
    throw DomainError({"checkpoint: the function returned ", results.size(), " variables, and ",
                       result_adjoints.size(), " when first called"});
  TapeState<T>& state = *tape.shared_state();
  for (const Variable<T>& result : results) state.require_own_if_active(result.link());
  state.reverse(tape.statement_count(), [&](T* adjoints) {
    add_adjoints<T>(adjoints, inputs, input_adjoints);
    add_adjoints<T>(adjoints, results, result_adjoints);
  });
  tape.adjoints(inputs, input_adjoints);
}

/// A part of the computation that is not recorded: the sweep computes it again. Its results are the
/// statements behind it.
/// \tparam Part  part(inputs, result_adjoints, input_adjoints) adds the part's derivatives to
///   input_adjoints, which are not 0 at the start
template <class T, class Part>
class CheckpointRecord final : public TapeRecord<T> {
 public:
  CheckpointRecord(Part part, std::vector<Variable<T>> inputs, std::size_t result_count)
      : part_(std::move(part)), inputs_(std::move(inputs)), result_count_(result_count) {}
  void pull_back(T* adjoints, std::size_t statement) override {
    const std::span<const T> result_adjoints(adjoints + statement + 1, result_count_);
    if (std::all_of(result_adjoints.begin(), result_adjoints.end(), [](const T& x) { return is_zero(x); }))
      return;
    std::vector<T> input_adjoints;  // 0 for a repeated variable's second entry
    for (const Variable<T>& input : inputs_)
      input_adjoints.push_back(input.is_active() ? std::exchange(adjoints[input.link().index()], T(0))
                                                 : T(0));
    part_(std::span<const Variable<T>>(inputs_), result_adjoints, std::span<T>(input_adjoints));
    add_adjoints<T>(adjoints, inputs_, input_adjoints);
  }
  void list_inputs(std::vector<std::uint32_t>& statements) const override {
    list_variables<T>(inputs_, statements);
  }
  [[nodiscard]] const char* operation() const noexcept override { return type_name<Part>(); }

 private:
  Part part_;
  std::vector<Variable<T>> inputs_;
  std::size_t result_count_;
};

/// Puts a part on the active tape. \param results  computed from passive copies of the inputs
/// \returns the results; passive, with nothing recorded, if all inputs are
/// \throws DomainError if an input is active but no tape is, or is not on the active tape
template <class T, class Part>
[[nodiscard]] std::vector<Variable<T>> record_checkpoint(Part part, std::vector<Variable<T>> inputs,
                                                         std::vector<Variable<T>> results) {
  if (!any_active<T>(inputs) || results.empty()) return results;
  auto& tape = TapeState<T>::require_active();
  for (const Variable<T>& input : inputs) tape.require_own_if_active(input.link());
  using Record = CheckpointRecord<T, Part>;
  static_cast<void>(tape.append_record(
      std::make_unique<Record>(std::move(part), std::move(inputs), results.size()), results.size()));
  for (Variable<T>& result : results) result = {result.value(), tape.append_input()};
  return results;
}

/// The part that is one call of a function.
template <class T, class Function>
struct FunctionPart {
  Function function;

  void operator()(std::span<const Variable<T>> inputs, std::span<const T> result_adjoints,
                  std::span<T> input_adjoints) const {
    SpareTape<T> tape;
    const auto scope = tape->activate();
    std::vector<Variable<T>> own;
    for (const Variable<T>& input : inputs)
      own.push_back(input.is_active() ? tape->input(input.value()) : input);
    const std::vector<Variable<T>> results = function(std::span<const Variable<T>>(own));
    sweep_results<T>(*tape, results, result_adjoints, own, input_adjoints);
  }
};
}  // namespace detail

/// Computes a function of several variables and records it as one statement, whose gradient is taken at once:
/// for parts with many operations and few inputs. The tape keeps nothing else of them.
/// \param function takes a std::span<const Variable<T>> of the inputs' length, returns a Variable<T>, and
///                  uses no other active ones
template <class T, class Function>
[[nodiscard]] Variable<T> preaccumulate(const Function& function, std::span<const Variable<T>> inputs) {
  std::vector<T> partials(inputs.size()), values;
  for (const Variable<T>& input : inputs) values.push_back(input.value());
  const T value = [&] {
    detail::SpareTape<T> tape;
    const auto scope = tape->activate();
    const std::span<const Variable<T>> variables = tape.input(values);
    const Variable<T> result = function(variables);
    tape->reverse(result);
    tape->adjoints(variables, partials);
    return result.value();
  }();
  return record_partials<T>(value, inputs, partials);
}

/// Computes a function of several variables without recording it; every reverse() computes it again, on a
/// tape of its own. A long computation in n such pieces needs the tape of one of them at a time, and twice
/// the work.
/// \param function  takes std::span<const Variable<T>> of as many, and returns std::vector<Variable<T>>; it
///                  computes the same whenever called, uses no other active variables, and is copied
/// \returns passive variables, with nothing recorded, if all inputs are passive
/// \throws DomainError as any statement, and if the function uses other active variables
template <class T, class Function>
[[nodiscard]] std::vector<Variable<T>> checkpoint(Function function, std::span<const Variable<T>> inputs) {
  const std::vector<Variable<T>> constants = detail::passive_copies(inputs);
  const detail::PassiveOnly<T> check;
  std::vector<Variable<T>> results = function(std::span<const Variable<T>>(constants));
  if (detail::any_active<T>(results)) check.refuse("checkpoint: the function", "an input");
  return detail::record_checkpoint<T>(detail::FunctionPart<T, Function>{std::move(function)},
                                      {inputs.begin(), inputs.end()}, std::move(results));
}
}  // namespace tapestry

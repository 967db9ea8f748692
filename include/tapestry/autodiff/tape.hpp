#pragma once
#include <tapestry/autodiff/detail/tape/deferred_throw.hpp>
#include <tapestry/autodiff/detail/tape/first_non_finite.hpp>

/// \file
/// The first header of autodiff/: derivatives by reverse-mode automatic differentiation.
///
/// A program is a list of statements v_k = f_k(v_i, v_j, …). While it runs, the tape stores the partial
/// derivatives of each statement and the indices of its operands. The reverse sweep begins with the adjoint
/// v̄ = 1 of the result and goes through the statements backwards. Each adds to its operands' adjoints:
///
///   v̄_i += v̄_k · ∂f_k/∂v_i
///
///   run       input x  -->  statement 1  -->  statement 2  -->  …  -->  result y
///   reverse   x̄ = ∂y/∂x  <--  …  <--  statement 2  <--  statement 1  <--  ȳ = 1
///
/// One sweep gives the derivatives of one result with respect to all inputs, in time proportional to
/// the program's. An operation on arrays is a single record with a pullback, a function that does
/// the same for whole arrays.
///
/// Read next: variable.hpp, functions.hpp, array_variable.hpp and record.hpp. derivatives.hpp, jacobian.hpp
/// and checkpoint.hpp are built on these.

namespace tapestry {
template <class T>
class Variable;

namespace detail {
/// Whether array_variable.hpp makes an input of Values for a tape of T.
template <class T, class Values>
inline constexpr bool is_array_input = false;
}  // namespace detail

/// A place on a tape, to rewind to. Made by Tape::mark().
using Position = detail::TapePosition;

/// While it lives, its thread records on the tape that made it; afterwards on the previous tape again. Scopes
/// end in the reverse order of their beginning, on the thread that began them. A destructor cannot throw. If
/// a scope ends before one that began later, or on another thread, each operation that needs its thread's
/// active tape throws a DomainError until every scope of the thread has ended.
///
/// A scope can be returned, and put into an optional that is empty: scope.emplace(tape.activate()). It cannot
/// be assigned: the right scope would begin before the left one ends.
template <class T>
class ActiveScope {
  using State = detail::TapeState<T>;

 public:
  /// \throws DomainError if the tape is active on another thread, or scopes have ended out of order
  explicit ActiveScope(detail::Shared<State> state) : state_(std::move(state)) {
    if (State::active == &detail::disordered_tapes<T>) {
      if (State::scope_count == 0) State::active = &detail::no_tape<T>;  // told once
      detail::throw_inactive<T>(&detail::disordered_tapes<T>);
    }
    state_->claim.take(&State::active);
    previous_ = std::exchange(State::active, state_.get());
    depth_ = ++State::scope_count;
  }
  ActiveScope(ActiveScope&& other) noexcept = default;
  ActiveScope& operator=(ActiveScope&&) = delete;
  ~ActiveScope() {
    if (!state_) return;  // moved from
    if (!state_->claim.is_held_by(&State::active)) {
      State::active = &detail::disordered_tapes<T>;
      state_.abandon();  // the other thread still records there
      return;
    }
    const bool is_last = depth_ == State::scope_count && State::active == state_.get();
    State::scope_count -= State::scope_count > 0;  // 0 if this thread reuses the address of an ended one
    const bool is_only = State::scope_count == 0;
    State::active = is_last ? previous_ : is_only ? &detail::no_tape<T> : &detail::disordered_tapes<T>;
    state_->claim.release();
  }

 private:
  detail::Shared<State> state_;  // shared, so that a tape may end before its scope
  detail::WriteHead* previous_;
  std::size_t depth_;  // number of the thread's scopes when it began, itself included
};

/// Reverse-mode tape: records the operations on active variables, and runs their adjoints backwards.
///
///   Tape<double> tape;
///   auto scope = tape.activate();
///   Variable<double> x = tape.input(2.0);
///   Variable<double> y = x * x + x;
///   tape.reverse(y);                    // x.adjoint() == 5
///
/// Scalar statements (variable.hpp) and array operations (array_variable.hpp, record.hpp) share the tape, in
/// the order in which they ran. An operation whose inputs are all passive is not recorded. Every thread has
/// its own active tape for each T; one tape serves one thread at a time, activating it on two is a
/// DomainError. A variable of another tape, or of a tape since cleared or rewound, is a DomainError wherever
/// it is used. An exception in the middle of a recording leaves the tape unchanged by that operation. A tape
/// can be moved, also while active; the source is then an empty tape.
template <class T>
class Tape {
 public:
  Tape() = default;
  Tape(Tape&& other) noexcept = default;
  Tape& operator=(Tape&& other) noexcept = default;

  /// Makes this the tape that the calling thread records on, until the result is destroyed.
  [[nodiscard]] ActiveScope<T> activate() { return ActiveScope<T>(shared_state()); }

  /// A variable to differentiate by. The tape need not be active.
  [[nodiscard]] Variable<T> input(T value) {
    detail::TapeState<T>& state = this->state();
    state.require_idle("input");
    if (state.has_usual_room()) [[likely]]
      return {value, state.commit(detail::StatementKind::input, 1)};
    const detail::Link link = state.append_input();
    state.note_value(link, static_cast<double>(detail::value_of<detail::Base<T>>(value)));
    return Variable<T>(value, link);
  }

  /// The same for an Array<T, R>; returns an ArrayVariable<T, R>. Include array_variable.hpp for it.
  template <class Values>
  requires(!std::is_arithmetic_v<Values> &&
           (detail::is_array_input<T, Values> || !std::is_convertible_v<const Values&, std::span<const T>>))
      [[nodiscard]] auto input(Values values) {
    if constexpr (detail::is_array_input<T, Values>) {
      state().require_idle("input");
      return array_input(state(), std::move(values));
    } else {
      static_assert(detail::is_array_input<T, Values>,
                    "Tape::input() takes a number, a std::vector of numbers of the tape's type, or, with "
                    "tapestry/autodiff/array_variable.hpp, a tapestry::Array");
    }
  }

  /// Variables to differentiate by, of the values of a std::vector, std::array or std::span.
  [[nodiscard]] std::vector<Variable<T>> input(std::span<const T> values) {
    std::vector<Variable<T>> variables(values.size());
    input(values, variables);
    return variables;
  }

  /// Variables to differentiate by, of the given values; writes to the variables. Costs less than one by one.
  /// \throws DomainError unless there are as many variables as values
  void input(std::span<const T> values, std::span<Variable<T>> variables) {
    state().require_idle("input");
    require_equal_count("input", "values", values.size(), variables.size());
    for (std::size_t i = 0; i < values.size();) {
      std::size_t count = values.size() - i;
      detail::Link link = state().append_inputs(count);
      for (const std::size_t end = i + count; i < end; ++i, ++link) variables[i] = {values[i], link};
    }
    if (!state().is_watching()) return;
    for (const Variable<T>& variable : variables)
      state().note_value(variable.link(),
                         static_cast<double>(detail::value_of<detail::Base<T>>(variable.value())));
  }

  /// Finds memory beforehand, so that a first recording waits for none, and its first sweep. Adjoints of the
  /// last reverse() may be forgotten.
  /// \param statements, operands  statement_count() and operand_count() of such a recording
  /// \throws Error if there is not as much, DomainError if called from within a pullback
  void reserve(std::size_t statements, std::size_t operands) {
    state().require_idle("reserve");
    state().reserve(statements, operands);
  }

  /// While the result lives, statements recorded on this tape have this name, within the names of labels
  /// around it. clear() and rewind() forget labels begun since.
  [[nodiscard]] LabelScope<T> label(std::string name) { return {shared_state(), std::move(name)}; }

  /// From now on, checks each statement's value when it is recorded, which takes several times as long;
  /// partial derivatives are on the tape anyway, values are not. For duals, checks the numbers beneath.
  void watch_values(bool on = true) { state().watch_values(on); }

  /// The first statement with a partial derivative, or a value since watch_values(), that is not finite: the
  /// origin of a NaN. Results of operations with a pullback are not checked.
  ///
  ///   const auto scope = tape.label("loss");
  ///   …
  ///   if (const auto found = tape.first_non_finite()) throw NumericError(found->description());
  [[nodiscard]] std::optional<NonFinite> first_non_finite() const {
    return detail::first_non_finite(state());
  }

  /// How often in the last reverse() a zero met a number that is not finite. This library's rule: a
  /// zero passes nothing on and nothing through, on the tape and in duals: 0 · ∞ = 0 · NaN = 0
  /// wherever slopes are multiplied, in every sweep. Masks need the rule. The rule is wrong where the
  /// limit is not 0, as for √x · √x at 0, whose slope is 1: compute x there. Counts products of adjoints
  /// and recorded partial derivatives; products within one formula are not on the tape, unless its parts
  /// are assigned to variables.
  [[nodiscard]] ZeroProducts zero_products() const { return detail::zero_products(state()); }

  /// Sets every variable's adjoint to seed · d root / d variable. Adjoints start from zero each time, so that
  /// a second call repeats the first and does not add to it. A passive root is no error: every adjoint is
  /// then zero. A zero passes nothing on, see zero_products(). Where an infinite adjoint or a NaN has met a
  /// zero partial derivative, sweeps a second time by that rule: pullbacks are then called again. If a
  /// pullback throws, so does this; the tape stays usable, with the adjoints computed so far.
  /// \throws DomainError if root is not on this tape, or if called from within a pullback
  void reverse(const Variable<T>& root, T seed = T(1)) {
    const detail::Link link = root.link();
    detail::note_nan(root.value());
    detail::note_nan(seed);
    const auto sweep = [this, link, seed] {  // copies: with its address known, the root would live in memory
      state().require_own_if_active(link);
      state().reverse(link.index(), [&](T* adjoints) {
        if (link.is_active()) adjoints[link.index()] = seed;
      });
    };
    if (!detail::succeeds(sweep)) detail::throw_deferred();
  }

  /// The same for an ArrayVariable root and a seed of its extents: the transposed Jacobian times the seed.
  template <class ArrayRoot, class Seed>
  requires(!std::is_arithmetic_v<Seed>) void reverse(const ArrayRoot& root, const Seed& seed) {
    reverse_from_array(state(), root, seed);
  }

  /// The result of variable.adjoint(), without the need for an active tape: zero before the first reverse().
  [[nodiscard]] T adjoint(const Variable<T>& variable) const { return state().adjoint(variable.link()); }

  /// The same of many variables; writes to the adjoints.
  /// \throws DomainError unless there are as many adjoints as variables, or if one is not on this tape
  void adjoints(std::span<const Variable<T>> variables, std::span<T> adjoints) const {
    const auto read = [this, variables, adjoints] {
      require_equal_count("adjoints", "adjoints", adjoints.size(), variables.size());
      const detail::TapeState<T>& state = this->state();
      for (std::size_t i = 0; i < variables.size(); ++i) adjoints[i] = state.adjoint(variables[i].link());
    };
    if (!detail::succeeds(read)) detail::throw_deferred();
  }

  /// The present end of the tape.
  [[nodiscard]] Position mark() const { return state().mark(); }

  /// Forgets all that was recorded since the position; variables recorded before it remain.
  /// \throws DomainError if the position is not, or no longer, on this tape
  void rewind(const Position& position) { state().rewind(position); }

  /// Forgets everything but keeps the memory for the next recording.
  void clear() { state().clear(); }

  /// Number of inputs and operations recorded.
  [[nodiscard]] std::size_t statement_count() const { return state().statement_count(); }
  /// Number of pairs (variable, partial derivative) in all scalar statements. Reads the whole tape to count
  /// them.
  [[nodiscard]] std::size_t operand_count() const { return state().operand_count(); }
  /// Bytes of these: 1 a statement, 4 an operand of partial derivative 1 or −1, 4 + sizeof(T) any other.
  /// Adjoints, sizeof(T) a statement, and the memory of records come on top.
  [[nodiscard]] std::size_t statement_bytes() const { return state().statement_bytes(); }
  /// Number of array inputs, and operations with a pullback.
  [[nodiscard]] std::size_t record_count() const { return state().record_count(); }

  /// For extensions of the tape; see jacobian.hpp.
  [[nodiscard]] const detail::Shared<detail::TapeState<T>>& shared_state() const {
    const auto make = [this] { state_ = detail::Shared<detail::TapeState<T>>::make(); };
    if (!state_ && !detail::succeeds(make)) detail::throw_deferred();
    return state_;
  }

 private:
  static void require_equal_count(const char* operation, const char* what, std::size_t found,
                                  std::size_t variables) {
    if (found != variables)
      throw DomainError({operation, ": ", found, " ", what, " for ", variables, " variables"});
  }
  [[nodiscard]] detail::TapeState<T>& state() const { return *shared_state(); }

  mutable detail::Shared<detail::TapeState<T>> state_;  // made when first needed
};
}  // namespace tapestry

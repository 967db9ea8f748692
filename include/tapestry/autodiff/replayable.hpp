#pragma once
#include <compare>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tapestry/autodiff/expression.hpp>
#include <tapestry/autodiff/replay_program.hpp>
#include <tapestry/autodiff/tape_state.hpp>
#include <tapestry/autodiff/variable.hpp>
#include <tapestry/core/error.hpp>
#include <type_traits>

namespace tapestry {

/// Whether a recording remembers how comparisons came out, to refuse inputs for which one comes out
/// otherwise.
enum class Guards { record, ignore };

namespace detail {
template <std::floating_point T>
struct ReplayRecorder {
  ReplayRecording<T> recording{};
  std::uint32_t generation = next_generation();
  Guards guards = Guards::record;
  static inline constinit thread_local ReplayRecorder* active = nullptr;
};

template <class E>
[[nodiscard]] Link record_replayable(const E& formula);

template <class Operation, class X, class Y, class Z>
class Ternary;  // of functions/ternary.hpp
}  // namespace detail

/// The scalar of functions to be replayed. Like a Variable, but its operations are remembered by what they
/// compute, not by their partial derivatives; outside a recording it is a plain number.
template <std::floating_point T>
class Replayable {
 public:
  using ExpressionScalar = T;
  using value_type = T;
  static constexpr std::size_t operand_bound = 1;
  static constexpr bool observes_comparisons = true;
  static constexpr bool is_cheap = true;
  template <class Factor>
  static constexpr detail::OperandCounts operand_counts{
      std::same_as<Factor, detail::One>, std::same_as<Factor, detail::MinusOne>, std::same_as<Factor, T>};
  static constexpr bool always_pushes_all = true;

  constexpr Replayable() = default;
  template <Number N>
  constexpr Replayable(N value) : value_(static_cast<T>(value)) {}
  constexpr Replayable(T value, detail::Link link) : value_(value), link_(link) {}

  /// Records the formula.
  /// \throws DomainError if it uses a variable of another recording, or of one that has ended
  template <ScalarExpression E>
  requires(!std::same_as<E, Replayable> && std::same_as<typename E::ExpressionScalar, T>)
      Replayable(const E& formula)
      : value_(formula.value()), link_(detail::record_replayable(formula)) {}

  [[nodiscard]] constexpr T value() const { return value_; }
  [[nodiscard]] constexpr bool is_active() const { return link_.is_active(); }
  [[nodiscard]] constexpr detail::Link link() const { return link_; }
  template <class Y>
  requires(ScalarExpression<Y> || Number<Y>) Replayable& operator+=(const Y& y) { return *this = *this + y; }
  template <class Y>
  requires(ScalarExpression<Y> || Number<Y>) Replayable& operator-=(const Y& y) { return *this = *this - y; }
  template <class Y>
  requires(ScalarExpression<Y> || Number<Y>) Replayable& operator*=(const Y& y) { return *this = *this * y; }
  template <class Y>
  requires(ScalarExpression<Y> || Number<Y>) Replayable& operator/=(const Y& y) { return *this = *this / y; }

  template <class Factor, class Sink>
  void push(Factor factor, Sink& sink) const {
    sink.add(link_, factor);
  }
  template <class Leaves>
  void write(Leaves& leaves) const {
    leaves.add_variable(value_, link_);
  }
  template <class Leaves>
  [[nodiscard]] static Replayable read(Leaves& leaves) {
    return leaves.next_variable();
  }

 private:
  T value_ = T(0);
  detail::Link link_;
};

namespace detail {

/// Takes a formula apart, onto a recording. A passive variable becomes a slot that keeps its value.
template <class T>
struct RecordedLeaves {
  ReplayRecorder<T>& recorder;
  std::size_t operand_count = 0;
  std::size_t constant_count = 0;

  void add_constant(T value) {
    recorder.recording.constants.push_back(value);
    ++constant_count;
  }
  void add_variable(T value, Link link) {
    auto& recording = recorder.recording;
    if (link.is_active() && link.generation() != recorder.generation)
      throw DomainError("Replay: a variable of another recording, or of one that has ended");
    if (!link.is_active()) {
      link = Link(static_cast<std::uint32_t>(recording.slots.size()), recorder.generation);
      recording.slots.push_back(value);
    }
    recording.operands.push_back(link.index());
    ++operand_count;
  }
};

/// Makes a formula from the slots of a frame.
template <class T>
struct ReplayedLeaves {
  const T* values;
  const std::uint32_t* operand;
  const T* constant;
  [[nodiscard]] T next_constant() { return *constant++; }
  [[nodiscard]] Replayable<T> next_variable() {
    const std::uint32_t slot = *operand++;
    return {values[slot], Link(slot, 0)};
  }
};

template <class T>
struct PartialsSink {
  T* partial;
  template <class Factor>
  void add(Link, Factor factor) {
    *partial++ = as_number<T>(factor);
  }
};

template <class T>
struct AdjointsSink {
  T* adjoints;
  T adjoint;
  void add(Link link, One) { adjoints[link.index()] += adjoint; }
  void add(Link link, MinusOne) { adjoints[link.index()] -= adjoint; }
  void add(Link link, T partial) { adjoints[link.index()] += partial * adjoint; }
};

template <class E>
struct LeafCounts;
template <class T>
struct LeafCounts<Replayable<T>> {
  static constexpr std::size_t variables = 1, constants = 0;
};
template <class T>
struct LeafCounts<Constant<T>> {
  static constexpr std::size_t variables = 0, constants = 1;
};
template <class Operation, class X>
struct LeafCounts<Unary<Operation, X>> : LeafCounts<X> {};
template <class Operation, class X, class Y>
struct LeafCounts<Binary<Operation, X, Y>> {
  static constexpr std::size_t variables = LeafCounts<X>::variables + LeafCounts<Y>::variables;
  static constexpr std::size_t constants = LeafCounts<X>::constants + LeafCounts<Y>::constants;
};
template <class Operation, class X, class Y, class Z>
struct LeafCounts<Ternary<Operation, X, Y, Z>> {
  static constexpr std::size_t variables =
      LeafCounts<Binary<Operation, X, Y>>::variables + LeafCounts<Z>::variables;
  static constexpr std::size_t constants =
      LeafCounts<Binary<Operation, X, Y>>::constants + LeafCounts<Z>::constants;
};

/// Statements of expression type E. Those with costly functions keep their partial derivatives from the way
/// forwards; others compute them again, which needs no memory.
template <class E>
struct ReplayStatement {
  using T = typename E::ExpressionScalar;
  static constexpr std::size_t variables = LeafCounts<E>::variables;
  static constexpr std::size_t constants = LeafCounts<E>::constants;
  static constexpr bool keeps_partials = !is_cheap<E>() && pushes_all<E>();

  static void forward(const ReplayRun<T>& run, const ReplayArrays<T>& arrays) {
    ReplayedLeaves<T> leaves{arrays.values, arrays.operands + run.operand, arrays.constants + run.constant};
    T* const values = arrays.values + run.result;
    PartialsSink<T> partials{arrays.partials + run.partial};
    for (std::size_t i = 0, count = run.count; i < count; ++i) {
      const E formula = E::read(leaves);
      values[i] = formula.value();
      if constexpr (keeps_partials) formula.push(T(1), partials);
    }
  }

  static void backward(const ReplayRun<T>& run, const ReplayArrays<T>& arrays) {
    const T* const results = arrays.adjoints + run.result;
    for (std::size_t i = run.count; i-- > 0;) {
      const T adjoint = results[i];
      if (adjoint == T(0)) [[unlikely]]
        continue;
      const std::uint32_t* const operands = arrays.operands + run.operand + i * variables;
      if constexpr (keeps_partials) {
        const T* const partials = arrays.partials + run.partial + i * variables;
        for (std::size_t k = 0; k < variables; ++k) arrays.adjoints[operands[k]] += partials[k] * adjoint;
      } else {
        ReplayedLeaves<T> leaves{arrays.values, operands, arrays.constants + run.constant + i * constants};
        AdjointsSink<T> sink{arrays.adjoints, adjoint};
        E::read(leaves).push(One{}, sink);
      }
    }
  }

  static constexpr ReplayOperation<T> operation{
      forward, backward, variables, constants, keeps_partials ? variables : 0, true};
};

/// How two numbers compare, as a number.
struct ComparedAs {
  template <class T>
  static T value(T x, T y) {
    return x < y ? T(-1) : x > y ? T(1) : x == y ? T(0) : T(2);
  }
};

/// A comparison of two formulas, behind whose constants stands how it came out.
template <class X, class Y>
struct ReplayGuard {
  using T = typename X::ExpressionScalar;
  static constexpr std::size_t variables = LeafCounts<X>::variables + LeafCounts<Y>::variables;
  static constexpr std::size_t constants = LeafCounts<X>::constants + LeafCounts<Y>::constants + 1;

  static void forward(const ReplayRun<T>& run, const ReplayArrays<T>& arrays) {
    ReplayedLeaves<T> leaves{arrays.values, arrays.operands + run.operand, arrays.constants + run.constant};
    for (std::size_t i = 0; i < run.count; ++i) {
      const T x = X::read(leaves).value();
      const T y = Y::read(leaves).value();
      if (ComparedAs::value(x, y) != leaves.next_constant()) [[unlikely]]
        throw_otherwise(x, y);
    }
  }
  static void backward(const ReplayRun<T>&, const ReplayArrays<T>&) {}
  [[noreturn]] static void throw_otherwise(T x, T y) {
    throw DomainError("Replay: the comparison of " + std::to_string(x) + " with " + std::to_string(y) +
                      " comes out otherwise than when it was recorded; record again for these inputs");
  }

  static constexpr ReplayOperation<T> operation{forward, backward, variables, constants, 0, false};
};

template <class T, class X>
[[nodiscard]] auto as_expression(const X& x) {
  if constexpr (ScalarExpression<X>) {
    return x;
  } else {
    return Constant<T>(static_cast<T>(x));
  }
}

}  // namespace detail
/// Called by comparisons of Replayable formulas.
template <class X, class Y>
requires detail::FormulaOperands<X, Y>
void observe_comparison(const X& x, const Y& y, std::partial_ordering) {
  using T = detail::ScalarOf<X, Y>;
  detail::ReplayRecorder<T>* const recorder = detail::ReplayRecorder<T>::active;
  if (recorder == nullptr || recorder->guards == Guards::ignore) return;
  const auto left = detail::as_expression<T>(x);
  const auto right = detail::as_expression<T>(y);
  if (!left.is_active() && !right.is_active()) return;
  auto& recording = recorder->recording;
  const auto first_operand = static_cast<std::uint32_t>(recording.operands.size());
  const auto first_constant = static_cast<std::uint32_t>(recording.constants.size());
  detail::RecordedLeaves<T> leaves{*recorder};
  left.write(leaves);
  right.write(leaves);
  leaves.add_constant(detail::ComparedAs::value(left.value(), right.value()));
  using Guard =
      detail::ReplayGuard<std::remove_const_t<decltype(left)>, std::remove_const_t<decltype(right)>>;
  recording.statements.push_back({&Guard::operation, first_operand, first_constant, 0});
}
/// Puts a formula on the recording.
template <class E>
detail::Link detail::record_replayable(const E& formula) {
  using T = typename E::ExpressionScalar;
  if (!formula.is_active()) return {};
  ReplayRecorder<T>* const recorder = ReplayRecorder<T>::active;
  if (recorder == nullptr) throw DomainError("Replay: a variable of a recording that has ended");
  auto& recording = recorder->recording;
  const auto first_operand = static_cast<std::uint32_t>(recording.operands.size());
  const auto first_constant = static_cast<std::uint32_t>(recording.constants.size());
  RecordedLeaves<T> leaves{*recorder};
  formula.write(leaves);
  const Link link(static_cast<std::uint32_t>(recording.slots.size()), recorder->generation);
  recording.slots.push_back(formula.value());
  recording.statements.push_back(
      {&ReplayStatement<E>::operation, first_operand, first_constant, link.index()});
  return link;
}

}  // namespace tapestry

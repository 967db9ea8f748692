#pragma once
#include <algorithm>
#include <compare>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <tapestry/autodiff/replay/lane_statement.hpp>
#include <tapestry/autodiff/replay/replay_program.hpp>
#include <tapestry/autodiff/replay/replay_statement.hpp>
#include <tapestry/autodiff/tape/expression.hpp>
#include <tapestry/autodiff/tape/formula.hpp>
#include <tapestry/autodiff/tape/tape_state.hpp>
#include <tapestry/autodiff/variable.hpp>
#include <tapestry/core/error.hpp>
#include <type_traits>

namespace tapestry {

/// Whether a recording remembers how comparisons came out, to refuse inputs for which one comes out
/// otherwise.
enum class Guards { record, ignore };

namespace detail {
template <std::floating_point T, std::size_t Lanes>
struct ReplayRecorder {
  ReplayRecording<T> recording{};
  std::uint32_t generation = next_generation();
  Guards guards = Guards::record;
  static inline constinit thread_local ReplayRecorder* active = nullptr;
};

template <class E>
[[nodiscard]] Link record_replayable(const E& formula);
}  // namespace detail

/// The scalar of functions to be replayed. Like a Variable, but its operations are remembered by what they
/// compute, not by their partial derivatives; outside a recording it is a plain number.
template <std::floating_point T, std::size_t Lanes>
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

  Replayable& operator++() { return *this += 1; }
  Replayable& operator--() { return *this -= 1; }
  Replayable operator++(int) { return std::exchange(*this, *this + 1); }
  Replayable operator--(int) { return std::exchange(*this, *this - 1); }
  friend constexpr void swap(Replayable& x, Replayable& y) noexcept { std::swap(x, y); }

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
template <class T, std::size_t Lanes>
struct RecordedLeaves {
  ReplayRecorder<T, Lanes>& recorder;
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

/// What a recording says of a statement that is Scalar to one lane and LaneSweeps to several.
template <class Scalar, class LaneSweeps>
[[nodiscard]] auto replay_operation() {
  if constexpr (LaneSweeps::lanes == 1) {
    return &Scalar::operation;
  } else {
    return VectorLoops<LaneSweeps>::operation();
  }
}

/// Puts a formula on the recording.
template <class E>
Link record_replayable(const E& formula) {
  using T = typename E::ExpressionScalar;
  if (!formula.is_active()) return {};
  constexpr std::size_t lanes = LeafCounts<E>::lanes;
  ReplayRecorder<T, lanes>* const recorder = ReplayRecorder<T, lanes>::active;
  if (recorder == nullptr) throw DomainError("Replay: a variable of a recording that has ended");
  auto& recording = recorder->recording;
  const auto first_operand = static_cast<std::uint32_t>(recording.operands.size());
  const auto first_constant = static_cast<std::uint32_t>(recording.constants.size());
  RecordedLeaves<T, lanes> leaves{*recorder};
  formula.write(leaves);
  const Link link(static_cast<std::uint32_t>(recording.slots.size()), recorder->generation);
  recording.slots.push_back(formula.value());
  recording.statements.push_back({replay_operation<ReplayStatement<E>, LaneStatement<E>>(), first_operand,
                                  first_constant, link.index()});
  return link;
}

}  // namespace detail

/// Called by comparisons of Replayable formulas.
template <class X, class Y>
requires detail::FormulaOperands<X, Y>
void observe_comparison(const X& x, const Y& y, std::partial_ordering) {
  using T = detail::ScalarOf<X, Y>;
  const auto left = detail::as_expression<T>(x);
  const auto right = detail::as_expression<T>(y);
  using Left = std::remove_const_t<decltype(left)>;
  using Right = std::remove_const_t<decltype(right)>;
  constexpr std::size_t lanes = std::max(detail::LeafCounts<Left>::lanes, detail::LeafCounts<Right>::lanes);
  using Recorder = detail::ReplayRecorder<T, lanes>;
  Recorder* const recorder = Recorder::active;
  if (recorder == nullptr || recorder->guards == Guards::ignore) return;
  if (!left.is_active() && !right.is_active()) return;
  auto& recording = recorder->recording;
  const auto first_operand = static_cast<std::uint32_t>(recording.operands.size());
  const auto first_constant = static_cast<std::uint32_t>(recording.constants.size());
  detail::RecordedLeaves<T, lanes> leaves{*recorder};
  left.write(leaves);
  right.write(leaves);
  leaves.add_constant(detail::ComparedAs::value(left.value(), right.value()));
  recording.statements.push_back(
      {detail::replay_operation<detail::ReplayGuard<Left, Right>, detail::LaneGuard<Left, Right>>(),
       first_operand, first_constant, 0});
}

}  // namespace tapestry

#pragma once
#include <algorithm>
#include <compare>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <span>
#include <tapestry/autodiff/replay/lane_statement.hpp>
#include <tapestry/autodiff/replay/replay_program.hpp>
#include <tapestry/autodiff/replay/replay_recording.hpp>
#include <tapestry/autodiff/replay/replay_statement.hpp>
#include <tapestry/autodiff/tape/expression.hpp>
#include <tapestry/autodiff/tape/formula.hpp>
#include <tapestry/autodiff/tape/statement.hpp>
#include <tapestry/autodiff/tape/tape_state.hpp>
#include <tapestry/autodiff/variable.hpp>
#include <tapestry/core/error.hpp>
#include <type_traits>
#include <utility>
#include <vector>

namespace tapestry {

/// Whether a recording stores the outcomes of comparisons, to refuse inputs for which one comes out
/// otherwise.
enum class Guards { record, ignore };

namespace detail {
template <std::floating_point T, std::size_t Lanes>
struct ReplayRecorder {
  ReplayRecording<T> recording{};
  ReplayProgram<T>* program = nullptr;  ///< takes each window
  ReplayRuns<T> runs;
  std::uint32_t generation = next_generation();
  Guards guards = Guards::record;

  /// Ends a window; called after every replay_window statements, and at the end.
  void end_window() {
    if (program != nullptr) {
      program->append(recording, runs);
      recording.clear_window();
    }
    recording.first_of_window = recording.slot_count();
  }
  [[gnu::visibility("default")]] static inline constinit thread_local ReplayRecorder* active = nullptr;
};

template <class E>
[[nodiscard]] Link record_replayable(const E& formula);
}  // namespace detail

/// The scalar of functions to be replayed. Like a Variable, but its operations are recorded themselves, not
/// their partial derivatives; outside a recording it is a plain number.
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

/// Takes formulas apart into a recording. A passive variable becomes a slot that keeps its value.
template <class T, std::size_t Lanes>
class RecordedLeaves {
 public:
  /// \param variables, constants  in the formulas
  RecordedLeaves(ReplayRecorder<T, Lanes>& recorder, std::size_t variables, std::size_t constants)
      : recorder_(recorder),
        first_operand_(static_cast<std::uint32_t>(recorder.recording.operands.size())),
        first_constant_(static_cast<std::uint32_t>(recorder.recording.constants.size())),
        operand_(recorder.recording.operands.append(variables)),
        constant_(recorder.recording.constants.append(constants)) {}

  [[gnu::always_inline]] void add_constant(T value) { *constant_++ = value; }
  [[gnu::always_inline]] void add_variable(T value, Link link) {
    if (link.generation() != recorder_.generation) [[unlikely]]
      link = append_passive(value, link);
    depth_ = std::max(depth_, recorder_.recording.depth_of(link.index()));
    *operand_++ = link.index();
  }
  /// Makes one statement of all that was added.
  void finish(const ReplayOperation<T>* operation, std::uint32_t result) {
    auto& recording = recorder_.recording;
    *recording.statements.append(1) = {operation, first_operand_, first_constant_, result, depth_};
    if (recording.statements.size() % replay_window == 0) [[unlikely]]
      recorder_.end_window();
  }
  /// The same, and its result.
  [[nodiscard]] Link finish_result(const ReplayOperation<T>* operation) {
    const std::uint32_t result = recorder_.recording.append_slot(depth_ + 1);
    finish(operation, result);
    return Link(result, recorder_.generation);
  }

 private:
  [[gnu::noinline]] Link append_passive(T value, Link link) {
    if (link.is_active())
      throw DomainError("Replay: a variable of another recording, or of one that has ended");
    auto& recording = recorder_.recording;
    recording.given.push_back({recording.append_slot(0), value});
    return Link(recording.given.back().slot, recorder_.generation);
  }

  ReplayRecorder<T, Lanes>& recorder_;
  std::uint32_t first_operand_, first_constant_;
  std::uint32_t* operand_;
  T* constant_;
  std::uint32_t depth_ = 0;
};

/// Operation of a statement in a recording: from Scalar for one lane, from LaneSweeps for several.
template <class Scalar, class LaneSweeps>
[[nodiscard]] auto replay_operation() {
  if constexpr (LaneSweeps::lanes == 1) {
    return &Scalar::operation;
  } else {
    return VectorLoops<LaneSweeps>::operation();
  }
}

/// Records a formula.
template <class E>
Link record_replayable(const E& formula) {
  using T = typename E::ExpressionScalar;
  if (!formula.is_active()) return {};
  constexpr std::size_t lanes = LeafCounts<E>::lanes;
  ReplayRecorder<T, lanes>* const recorder = ReplayRecorder<T, lanes>::active;
  if (recorder == nullptr) throw DomainError("Replay: a variable of a recording that has ended");
  RecordedLeaves<T, lanes> leaves(*recorder, LeafCounts<E>::variables, LeafCounts<E>::constants);
  formula.write(leaves);
  return leaves.finish_result(replay_operation<ReplayStatement<E>, LaneStatement<E>>());
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
  using Guard = detail::ReplayGuard<Left, Right>;
  detail::RecordedLeaves<T, lanes> leaves(*recorder, Guard::variables, Guard::constants);
  left.write(leaves);
  right.write(leaves);
  leaves.add_constant(detail::ComparedAs::value(left.value(), right.value()));
  leaves.finish(detail::replay_operation<Guard, detail::LaneGuard<Left, Right>>(), 0);
}

}  // namespace tapestry

namespace tapestry::detail {

/// A function's operations, unless a program has taken them, and its result. Its inputs are slots 1, 2 and so
/// on.
template <class T>
struct RecordedFunction {
  ReplayRecording<T> recording{};
  std::uint32_t root = 0;  ///< slot of the result; 0 if it is a constant
  T constant = 0;
};

/// While it lives, it passes operations of this thread to the recorder.
template <class T, std::size_t Lanes>
class RecorderScope {
 public:
  explicit RecorderScope(ReplayRecorder<T, Lanes>& recorder)
      : previous_(std::exchange(ReplayRecorder<T, Lanes>::active, &recorder)) {}
  RecorderScope(const RecorderScope&) = delete;
  RecorderScope& operator=(const RecorderScope&) = delete;
  ~RecorderScope() { ReplayRecorder<T, Lanes>::active = previous_; }

 private:
  ReplayRecorder<T, Lanes>* previous_;
};

/// Calls function(inputs), or function(pointer to the first).
/// \param program  takes the recording, a window at a time; if there is none, the recording is whole
template <std::size_t Lanes, class T, class Function>
[[nodiscard]] RecordedFunction<T> record_function(const Function& function, std::span<const T> inputs,
                                                  Guards guards, ReplayProgram<T>* program = nullptr) {
  using Scalar = Replayable<T, Lanes>;
  ReplayRecorder<T, Lanes> recorder;
  recorder.guards = guards;
  recorder.program = program;
  std::vector<Scalar> variables;
  variables.reserve(inputs.size());
  recorder.recording.append_inputs(inputs.size());
  for (const T input : inputs)
    variables.emplace_back(input,
                           Link(static_cast<std::uint32_t>(variables.size() + 1), recorder.generation));
  const RecorderScope<T, Lanes> scope(recorder);
  const Scalar root = [&]() -> Scalar {
    if constexpr (std::invocable<const Function&, const Scalar*>) {
      return function(variables.data());
    } else {
      return function(std::span<const Scalar>(variables));
    }
  }();
  if (root.is_active() && root.link().generation() != recorder.generation)
    throw DomainError("Replay: the function returns a variable of another recording");
  recorder.end_window();
  return {std::move(recorder.recording), root.is_active() ? root.link().index() : 0, root.value()};
}

}  // namespace tapestry::detail

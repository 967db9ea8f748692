#pragma once
#include <deque>
#include <tapestry/autodiff/detail/arrays/adjoint_lane.hpp>
#include <tapestry/autodiff/tape.hpp>
#include <tapestry/core/parallel.hpp>

namespace tapestry {
namespace detail {
/// The adjoint of one array on a tape, allocated when first needed; in sweeps of several roots, one for each
/// root, chosen by the tape's AdjointLane. Shared by the tape's record and the variables that name it; the
/// record detaches it when the tape forgets it.
template <class T, std::size_t Rank>
class ArrayAdjoint {
 public:
  explicit ArrayAdjoint(const Extents<Rank>& extents, AdjointLane current = nullptr)
      : extents_(extents), current_(std::move(current)) {}
  ArrayAdjoint(const ArrayAdjoint&) = delete;
  ArrayAdjoint& operator=(const ArrayAdjoint&) = delete;
  ~ArrayAdjoint() { detach(); }

  /// The adjoint, to add to.
  [[nodiscard]] Array<T, Rank>& touch() {
    Lane& lane = made_zero(this->lane());
    lane.holds = Holds::sum;
    return lane.adjoint;
  }
  /// Whether the adjoint still has the extents of its array; otherwise forgets it.
  [[nodiscard]] bool keeps_shape() {
    if (lane().adjoint.shape() == extents_) return true;
    release(lane());
    return false;
  }
  [[nodiscard]] const Extents<Rank>& extents() const { return extents_; }
  /// The adjoint, to read; zeros when nothing was added.
  [[nodiscard]] const Array<T, Rank>& read() { return read(lane()); }
  /// The adjoint that a sweep of several roots left for one of them.
  [[nodiscard]] const Array<T, Rank>& read_lane(std::size_t number) { return read(lane(number)); }
  [[nodiscard]] bool is_touched() { return lane().holds == Holds::sum; }
  void forget() noexcept {
    if (const std::size_t number = lane_number(); number <= several_.size())
      lane(number).holds = Holds::forgotten;
  }
  /// Frees the memory of an adjoint that is next added to, not read.
  void release() { release(lane()); }
  void detach() noexcept {
    release(single_);
    for (Lane& lane : several_) release(lane);
    is_detached_ = true;
  }

 private:
  enum class Holds { forgotten, zeros, sum };

  /// The adjoint for one root.
  struct Lane {
    Array<T, Rank> adjoint;
    Holds holds = Holds::forgotten;
  };

  [[nodiscard]] std::size_t lane_number() const { return current_ == nullptr ? 0 : *current_; }
  [[nodiscard]] Lane& lane() { return lane(lane_number()); }
  [[nodiscard]] Lane& lane(std::size_t number) {
    if (number == 0) return single_;
    if (number > several_.size()) several_.resize(number);
    return several_[number - 1];
  }
  [[nodiscard]] const Array<T, Rank>& read(Lane& lane) {
    if (is_detached_) throw DomainError("adjoint: the array's tape was cleared, rewound or destroyed");
    return made_zero(lane).adjoint;
  }
  void release(Lane& lane) noexcept {
    lane.holds = Holds::forgotten;
    lane.adjoint = Array<T, Rank>();
  }
  Lane& made_zero(Lane& lane) {
    if (lane.holds != Holds::forgotten) return lane;
    if (lane.adjoint.shape() != extents_ || lane.adjoint.storage().size() != count_of(extents_))
      lane.adjoint.resize(extents_);
    constexpr std::size_t block = std::size_t(1) << 16U;
    parallel_for_blocks(lane.adjoint.size(), block, [to = lane.adjoint.data()](auto begin, auto end) {
      std::fill(to + begin, to + end, T(0));
    });
    lane.holds = Holds::zeros;
    return lane;
  }

  Extents<Rank> extents_;
  AdjointLane current_;
  Lane single_;
  std::deque<Lane> several_;  // lanes from 1 on; elements stay in place
  bool is_detached_ = false;
};

template <class T, std::size_t Rank>
class InputRecord final : public TapeRecord<T> {
 public:
  explicit InputRecord(std::shared_ptr<ArrayAdjoint<T, Rank>> adjoint) : adjoint_(std::move(adjoint)) {}
  ~InputRecord() override { adjoint_->detach(); }
  void pull_back(T*, std::size_t) override {}
  void list_inputs(std::vector<std::uint32_t>&) const override {}
  void forget_adjoint() noexcept override { adjoint_->forget(); }

 private:
  std::shared_ptr<ArrayAdjoint<T, Rank>> adjoint_;
};

template <class T, std::size_t Rank>
inline constexpr bool is_array_input<T, Array<T, Rank>> = true;
template <class T, std::size_t Rank>
inline constexpr bool is_array_input<T, ArrayVariable<T, Rank>> = true;

/// Tape::input() of an array.
template <class T, std::size_t Rank>
[[nodiscard]] ArrayVariable<T, Rank> array_input(TapeState<T>& state, Array<T, Rank> value) {
  return array_input(state, ArrayVariable<T, Rank>(std::move(value)));
}

/// Tape::input() of an array variable: the same value, without a copy, as a new input.
template <class T, std::size_t Rank>
[[nodiscard]] ArrayVariable<T, Rank> array_input(TapeState<T>& state, const ArrayVariable<T, Rank>& value) {
  auto adjoint = std::make_shared<ArrayAdjoint<T, Rank>>(value.shape(), lane_of(state));
  const Link link = state.append_record(std::make_unique<InputRecord<T, Rank>>(adjoint));
  return {value.shared_value(), std::move(adjoint), link};
}

/// Tape::reverse() from an array.
template <class T, std::size_t Rank>
void reverse_from_array(TapeState<T>& state, const ArrayVariable<T, Rank>& root, const Array<T, Rank>& seed) {
  require_shape("reverse", "seed", seed, root.shape());
  for (const T entry : seed) note_nan(entry);
  state.require_own_if_active(root.link());
  state.reverse(root.link().index(), [&](T*) {
    if (root.is_active()) root.shared_adjoint()->touch() = seed;
  });
}
}  // namespace detail

/// An array that a tape can differentiate by. An Array<T, Rank> converts to a passive one, which costs no
/// tape. The value never changes; copies share it and their record, and cost little. Formulas of arrays
/// (array_functions.hpp) are evaluated and recorded, as one operation, when they become an ArrayVariable or
/// are summed. Write `ArrayVariable<T, 2> y = x * x;`, since `auto` would keep the formula (safely, by value)
/// and evaluate it anew wherever it is used.
template <class T, std::size_t Rank>
class ArrayVariable {
 public:
  using value_type = T;
  static constexpr std::size_t rank = Rank;

  ArrayVariable() : ArrayVariable(Array<T, Rank>()) {}
  /// A passive variable of this value.
  ArrayVariable(Array<T, Rank> value) : value_(std::make_shared<const Array<T, Rank>>(std::move(value))) {}
  /// A value that others share, without a copy.
  explicit ArrayVariable(std::shared_ptr<const Array<T, Rank>> value) : value_(std::move(value)) {}
  /// Records the formula as one operation of the active tape; a passive formula records nothing.
  template <ArrayExpression E>
  requires(E::rank == Rank && std::same_as<typename E::ArrayScalar, T>) ArrayVariable(const E& formula)
      : ArrayVariable(evaluated(formula)) {}
  /// Copies share value and adjoint.
  ArrayVariable(const ArrayVariable&) = default;  // also for moves: a moved-from variable keeps its value
  ArrayVariable& operator=(const ArrayVariable&) = default;
  ~ArrayVariable() = default;

  /// For operations with records of their own; record.hpp is more convenient.
  ArrayVariable(std::shared_ptr<const Array<T, Rank>> value,
                std::shared_ptr<detail::ArrayAdjoint<T, Rank>> adjoint, detail::Link link)
      : value_(std::move(value)), adjoint_(std::move(adjoint)), link_(link) {}

  // Elements are named, for a loop over them would record each:
  void operator[](std::size_t) const =
      delete;  // take element(x, {i}) or select(x, ...) of array_functions.hpp
  void operator()(std::size_t, std::size_t = 0, std::size_t = 0, std::size_t = 0) const = delete;  // as well
  void begin() const = delete;  // take sum(x), element(x, {i}) or value()

  /// The numbers; they never change.
  [[nodiscard]] const Array<T, Rank>& value() const { return *value_; }
  /// The value for a pullback to keep, without a copy.
  [[nodiscard]] const std::shared_ptr<const Array<T, Rank>>& shared_value() const { return value_; }
  /// The extents of value().
  [[nodiscard]] const Extents<Rank>& shape() const { return value_->shape(); }
  /// Number of elements of value().
  [[nodiscard]] std::size_t size() const { return value_->size(); }

  /// Whether the variable is on a tape.
  [[nodiscard]] bool is_active() const { return link_.is_active(); }

  /// d root / d variable of the last reverse(), of the extents of value(); zeros before it, for passive
  /// variables, and where the root does not depend on the variable. Needs no active tape. The reference is
  /// valid until the tape is next reversed, cleared, rewound over the variable, or destroyed.
  /// \throws DomainError if that has happened, except reversing
  [[nodiscard]] const Array<T, Rank>& adjoint() const {
    if (adjoint_ == nullptr) adjoint_ = std::make_shared<detail::ArrayAdjoint<T, Rank>>(value_->shape());
    return adjoint_->read();
  }

  /// The place where it was recorded.
  [[nodiscard]] const detail::Link& link() const { return link_; }
  /// The adjoint that records write to; null for a passive variable.
  [[nodiscard]] const std::shared_ptr<detail::ArrayAdjoint<T, Rank>>& shared_adjoint() const {
    return adjoint_;
  }

 private:
  std::shared_ptr<const Array<T, Rank>> value_;
  mutable std::shared_ptr<detail::ArrayAdjoint<T, Rank>> adjoint_;  // a passive variable's is made on demand
  detail::Link link_;
};

/// A passive variable of the same value, which stops the gradient; of duals a constant.
template <class T, std::size_t Rank>
[[nodiscard]] ArrayVariable<T, Rank> passive(const ArrayVariable<T, Rank>& array) {
  if constexpr (DualNumber<T>) {
    Array<T, Rank> constants = array.value();
    for (T& element : constants.storage()) element = T(element.value());
    return constants;
  } else {
    return {array.shared_value(), nullptr, detail::Link{}};
  }
}
}  // namespace tapestry

#pragma once
#include <cstddef>
#include <memory>
#include <tapestry/autodiff/arrays/array_memory.hpp>
#include <tapestry/autodiff/tape.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <type_traits>
#include <utility>

namespace tapestry {
namespace detail {

/// The adjoint of one array on a tape, allocated when first needed. Shared by the tape's record and the
/// variables that name it; the record detaches it when the tape forgets it.
template <class T, std::size_t Rank>
class ArrayAdjoint {
 public:
  explicit ArrayAdjoint(const Extents<Rank>& extents, std::shared_ptr<ArrayMemory<T>> memory = nullptr)
      : extents_(extents), memory_(std::move(memory)) {}
  ArrayAdjoint(const ArrayAdjoint&) = delete;
  ArrayAdjoint& operator=(const ArrayAdjoint&) = delete;
  ~ArrayAdjoint() { detail::release(adjoint_, memory_.get()); }

  /// To add to.
  [[nodiscard]] Array<T, Rank>& touch() {
    make_zero_if_forgotten();
    holds_ = Holds::sum;
    return adjoint_;
  }
  /// Whether it still has the extents of its array. Else forgets it.
  [[nodiscard]] bool keeps_shape() {
    if (adjoint_.shape() == extents_) return true;
    release();
    return false;
  }
  [[nodiscard]] const Extents<Rank>& extents() const { return extents_; }
  /// To read; zeros when nothing was added.
  [[nodiscard]] const Array<T, Rank>& read() {
    if (holds_ == Holds::nothing_any_more)
      throw DomainError("adjoint: the array's tape was cleared, rewound or destroyed");
    make_zero_if_forgotten();
    return adjoint_;
  }
  [[nodiscard]] bool is_touched() const noexcept { return holds_ == Holds::sum; }
  void forget() noexcept { holds_ = Holds::forgotten; }
  /// Frees the memory of what nobody will read until it is next added to.
  void release() noexcept {
    holds_ = Holds::forgotten;
    detail::release(adjoint_, memory_.get());
  }
  void detach() noexcept {
    release();
    holds_ = Holds::nothing_any_more;
  }

 private:
  enum class Holds { forgotten, zeros, sum, nothing_any_more };

  void make_zero_if_forgotten() {
    if (holds_ != Holds::forgotten) return;
    if (adjoint_.shape() != extents_ || adjoint_.storage().size() != count_of(extents_))
      allocate(adjoint_, extents_, memory_.get());
    for (T& element : adjoint_.storage()) element = T(0);
    holds_ = Holds::zeros;
  }

  Extents<Rank> extents_;
  std::shared_ptr<ArrayMemory<T>> memory_;
  Array<T, Rank> adjoint_;
  Holds holds_ = Holds::forgotten;
};

template <class T, std::size_t Rank>
class InputRecord final : public TapeRecord<T> {
 public:
  explicit InputRecord(std::shared_ptr<ArrayAdjoint<T, Rank>> adjoint) : adjoint_(std::move(adjoint)) {}
  ~InputRecord() override { adjoint_->detach(); }
  void pull_back(T*, std::size_t) override {}
  void forget_adjoint() noexcept override { adjoint_->forget(); }

 private:
  std::shared_ptr<ArrayAdjoint<T, Rank>> adjoint_;
};
}  // namespace detail

/// A formula of array variables that has not been assigned to one yet. Each has the scalar type, the rank,
/// extents, and the variables it is made of, in order, as leaves().
template <class E>
concept ArrayExpression = requires {
  typename std::remove_cvref_t<E>::ArrayScalar;
};

/// An array that a tape can differentiate by. An Array<T, Rank> converts to a passive one, which costs no
/// tape. The value never changes; copies share it and their record, and cost little.
/// Formulas of arrays (array_functions.hpp) are evaluated and recorded, as one operation, when they become an
/// ArrayVariable or are summed: write `ArrayVariable<T, 2> y = x * x;`, since `auto` would keep the formula
/// (safely, by value) and evaluate it anew wherever it is used.
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
  requires(std::is_same_v<typename E::ArrayScalar, T>&& E::rank == Rank) ArrayVariable(const E& formula)
      : ArrayVariable(evaluated(formula)) {}
  /// Copies share value and adjoint.
  ArrayVariable(const ArrayVariable&) = default;  // also for moves: a moved-from variable keeps its value
  ArrayVariable& operator=(const ArrayVariable&) = default;
  ~ArrayVariable() = default;

  /// For those who record operations themselves; see record.hpp for the convenient way.
  ArrayVariable(std::shared_ptr<const Array<T, Rank>> value,
                std::shared_ptr<detail::ArrayAdjoint<T, Rank>> adjoint, detail::Link link)
      : value_(std::move(value)), adjoint_(std::move(adjoint)), link_(link) {}

  /// The numbers; they never change.
  [[nodiscard]] const Array<T, Rank>& value() const { return *value_; }
  /// The value as a pullback may keep it, without a copy.
  [[nodiscard]] const std::shared_ptr<const Array<T, Rank>>& shared_value() const { return value_; }
  /// The extents of value().
  [[nodiscard]] const Extents<Rank>& shape() const { return value_->shape(); }
  /// How many numbers value() has.
  [[nodiscard]] std::size_t size() const { return value_->size(); }

  /// Whether a tape knows the variable.
  [[nodiscard]] bool is_active() const { return link_.is_active(); }

  /// d root / d variable of the last reverse(), of the extents of value(); zeros before it, for passive
  /// variables, and where the root does not depend on the variable. Needs no active tape. The reference
  /// holds until the tape is next reversed, cleared, rewound over the variable, or destroyed.
  /// \throws DomainError if that has happened, but for reversing
  [[nodiscard]] const Array<T, Rank>& adjoint() const {
    if (adjoint_ == nullptr) adjoint_ = std::make_shared<detail::ArrayAdjoint<T, Rank>>(value_->shape());
    return adjoint_->read();
  }

  /// Where it was recorded.
  [[nodiscard]] const detail::Link& link() const { return link_; }
  /// The adjoint that records write to; null for a passive variable.
  [[nodiscard]] const std::shared_ptr<detail::ArrayAdjoint<T, Rank>>& shared_adjoint() const {
    return adjoint_;
  }

 private:
  std::shared_ptr<const Array<T, Rank>> value_;
  mutable std::shared_ptr<detail::ArrayAdjoint<T, Rank>>
      adjoint_;  // a passive variable's is made when asked for
  detail::Link link_;
};

/// A passive variable of the same value, which stops the gradient.
template <class T, std::size_t Rank>
[[nodiscard]] ArrayVariable<T, Rank> passive(const ArrayVariable<T, Rank>& array) {
  return {array.shared_value(), nullptr, detail::Link{}};
}

namespace detail {
/// Tape::input() of an array.
template <class T, std::size_t Rank>
[[nodiscard]] ArrayVariable<T, Rank> array_input(TapeState<T>& state, Array<T, Rank> value) {
  auto shared = std::make_shared<const Array<T, Rank>>(std::move(value));
  auto adjoint = std::make_shared<ArrayAdjoint<T, Rank>>(shared->shape(), memory_of(state));
  const Link link = state.append_record(std::make_unique<InputRecord<T, Rank>>(adjoint));
  return {std::move(shared), std::move(adjoint), link};
}

/// Tape::input() of what is already an array variable: the same value, without a copy, as a new input.
template <class T, std::size_t Rank>
[[nodiscard]] ArrayVariable<T, Rank> array_input(TapeState<T>& state, const ArrayVariable<T, Rank>& value) {
  auto adjoint = std::make_shared<ArrayAdjoint<T, Rank>>(value.shape(), memory_of(state));
  const Link link = state.append_record(std::make_unique<InputRecord<T, Rank>>(adjoint));
  return {value.shared_value(), std::move(adjoint), link};
}

/// Tape::reverse() from an array.
template <class T, std::size_t Rank>
void reverse_from_array(TapeState<T>& state, const ArrayVariable<T, Rank>& root, const Array<T, Rank>& seed) {
  require_shape("reverse", "seed", seed, root.shape());
  state.require_own_if_active(root.link());
  state.reverse(root.link().index(), [&](T*) {
    if (root.is_active()) root.shared_adjoint()->touch() = seed;
  });
}
}  // namespace detail

}  // namespace tapestry

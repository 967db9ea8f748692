#pragma once
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/autodiff/variable.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>

/// Slots that a record keeps of its inputs, so that its pullback finds their adjoints.
namespace tapestry::detail {

/// A scalar input of a record, and the place of its adjoint.
template <class T>
struct ScalarSlot {
  Link link;
  [[nodiscard]] bool is_active() const { return link.is_active(); }
  void require_own(const TapeState<T>& state) const { state.require_own_if_active(link); }
  void list(std::vector<std::uint32_t>& statements) const {
    if (link.is_active()) statements.push_back(link.index());
  }
  [[nodiscard]] T* adjoint(T* adjoints) const {
    return !link.is_active() ? nullptr : adjoints + link.index();
  }
  static void require_shape() {}
};

/// An array input of a record. Its adjoint belongs to an earlier record, which the tape forgets later.
template <class T, std::size_t Rank>
struct ArraySlot {
  Link link;
  ArrayAdjoint<T, Rank>* array_adjoint = nullptr;
  [[nodiscard]] bool is_active() const { return link.is_active(); }
  void require_own(const TapeState<T>& state) const { state.require_own_if_active(link); }
  void list(std::vector<std::uint32_t>& statements) const {
    if (link.is_active()) statements.push_back(link.index());
  }
  [[nodiscard]] Array<T, Rank>* adjoint(T*) const {
    return !link.is_active() ? nullptr : &array_adjoint->touch();
  }
  /// \throws ShapeError if a pullback has put an array of other extents there
  void require_shape() const {
    if (link.is_active() && !array_adjoint->keeps_shape())
      throw ShapeError({"pullback: has changed the extents of the adjoint of an input ",
                        array_adjoint->extents(), "; it must add to it"});
  }
};

/// Inputs of one kind, as many as there are at run time.
template <class T, class Slot>
struct ListSlot {
  std::vector<Slot> entries;
  [[nodiscard]] bool is_active() const {
    return std::any_of(entries.begin(), entries.end(), [](const Slot& slot) { return slot.is_active(); });
  }
  void require_own(const TapeState<T>& state) const {
    for (const Slot& slot : entries) slot.require_own(state);
  }
  void list(std::vector<std::uint32_t>& statements) const {
    for (const Slot& slot : entries) slot.list(statements);
  }
  [[nodiscard]] auto adjoint(T* adjoints) const {
    std::vector<decltype(entries.front().adjoint(adjoints))> each;
    each.reserve(entries.size());
    for (const Slot& slot : entries) each.push_back(slot.adjoint(adjoints));
    return each;
  }
  void require_shape() const {
    for (const Slot& slot : entries) slot.require_shape();
  }
};

template <class T, ScalarExpression E>
requires std::same_as<typename E::ExpressionScalar, T>
[[nodiscard]] ScalarSlot<T> slot_of(const E& input) { return {Variable<T>(input).link()}; }

template <class T>
[[nodiscard]] ScalarSlot<T> slot_of(Number auto) {
  return {};
}

template <class T, std::size_t Rank>
[[nodiscard]] ArraySlot<T, Rank> slot_of(const ArrayVariable<T, Rank>& input) {
  if (!input.is_active()) return {};
  return {input.link(), input.shared_adjoint().get()};
}

template <class T, std::size_t Rank>
[[nodiscard]] ArraySlot<T, Rank> slot_of(const Array<T, Rank>&) {
  return {};
}

template <class T, class Input>
[[nodiscard]] auto slot_of(std::span<const Input> inputs) {
  ListSlot<T, decltype(slot_of<T>(inputs.front()))> list;
  list.entries.reserve(inputs.size());
  for (const Input& input : inputs) list.entries.push_back(slot_of<T>(input));
  return list;
}

template <class T, class Input>
[[nodiscard]] auto slot_of(const std::vector<Input>& inputs) {
  return slot_of<T>(std::span<const Input>(inputs));
}

/// The active tape, if any slot is active; else null.
/// \throws DomainError if a slot is active but no tape is, or is not on the active tape
template <class T, class... Slots>
[[nodiscard]] TapeState<T>* tape_of(const Slots&... slot) {
  if (!(slot.is_active() || ...)) return nullptr;
  TapeState<T>& state = TapeState<T>::require_active();
  (slot.require_own(state), ...);
  return &state;
}

}  // namespace tapestry::detail

#pragma once
#include <algorithm>
#include <tapestry/autodiff/variable.hpp>
#include <tuple>

namespace tapestry {
/// States that a pullback is written for duals: it computes in the scalar of its tape throughout, and
/// captures values with their tangents, or is linear. check_hessian() tests that.
template <class Pullback>
struct CarriesTangents {
  Pullback pullback;
};

namespace detail {
/// An input that a record keeps, so that its pullback finds the input's adjoint.
template <class T>
struct InputSlot {
  Link link;
  [[nodiscard]] bool is_active() const { return link.is_active(); }
  void require_own(const TapeState<T>& state) const { state.require_own_if_active(link); }
  void list(std::vector<std::uint32_t>& statements) const {
    if (link.is_active()) statements.push_back(link.index());
  }
};

template <class T>
struct ScalarSlot : InputSlot<T> {
  [[nodiscard]] T* adjoint(T* adjoints) const {
    return !this->is_active() ? nullptr : adjoints + this->link.index();
  }
  static void require_shape() {}
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

/// Names the scalar of a tape, and has lookups of slot_of() find those that are declared later, for arrays.
template <class T>
struct SlotFor {};

template <class T, ScalarExpression E>
requires std::same_as<typename E::ExpressionScalar, T>
[[nodiscard]] ScalarSlot<T> slot_of(SlotFor<T>, const E& input) { return {{Variable<T>(input).link()}}; }

template <class T>
[[nodiscard]] ScalarSlot<T> slot_of(SlotFor<T>, Number auto) {
  return {};
}

template <class T, class Input>
[[nodiscard]] auto slot_of(SlotFor<T> slot_for, std::span<const Input> inputs) {
  ListSlot<T, decltype(slot_of(slot_for, inputs.front()))> list;
  list.entries.reserve(inputs.size());
  for (const Input& input : inputs) list.entries.push_back(slot_of(slot_for, input));
  return list;
}
template <class T, class Input>
[[nodiscard]] auto slot_of(SlotFor<T> slot_for, const std::vector<Input>& inputs) {
  return slot_of(slot_for, std::span<const Input>(inputs));
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

/// The part of an operation's record that holds its pullback and its inputs; Base is TapeRecord<T> or more.
template <class T, class Base, class Pullback, class... Slots>
class CallableRecord : public Base {
 public:
  template <class... Parts>
  explicit CallableRecord(Pullback pullback, std::tuple<Slots...> inputs, Parts&&... of_base)
      : Base(std::forward<Parts>(of_base)...), pullback_(std::move(pullback)), inputs_(std::move(inputs)) {}
  void list_inputs(std::vector<std::uint32_t>& statements) const final {
    std::apply([&](const auto&... slot) { (slot.list(statements), ...); }, inputs_);
  }
  [[nodiscard]] const char* operation() const noexcept final { return type_name<Pullback>(); }

 protected:
  /// Passes the result's adjoint on to the inputs.
  /// \throws ShapeError, see ArraySlot::require_shape()
  template <class Adjoint>
  void call_pullback(const Adjoint& adjoint, T* adjoints) {
    std::apply(
        [&](const auto&... slot) {
          pullback_(adjoint, slot.adjoint(adjoints)...);
          (slot.require_shape(), ...);
        },
        inputs_);
  }

 private:
  Pullback pullback_;
  std::tuple<Slots...> inputs_;
};

template <class T, class Pullback, class... Slots>
class ScalarRecord final : public CallableRecord<T, TapeRecord<T>, Pullback, Slots...> {
 public:
  using CallableRecord<T, TapeRecord<T>, Pullback, Slots...>::CallableRecord;
  void pull_back(T* adjoints, std::size_t statement) override {
    if (const T adjoint = adjoints[statement]; !is_zero(adjoint)) this->call_pullback(adjoint, adjoints);
  }
};

/// Owner of a record before a tape takes it; std::unique_ptr brings more than all that a tape includes.
template <class Record>
struct NewRecord {
  explicit NewRecord(Record* made) : record(made) {}
  NewRecord(const NewRecord&) = delete;
  NewRecord& operator=(const NewRecord&) = delete;
  ~NewRecord() { delete record; }
  [[nodiscard]] Record* release() { return std::exchange(record, nullptr); }

  Record* record;
};

template <class T, class Pullback, class... Slots>
[[nodiscard]] Variable<T> record_scalar_slots(T value, Pullback pullback, Slots... slot) {
  TapeState<T>* const state = tape_of<T>(slot...);
  if (state == nullptr) return value;
  using Record = ScalarRecord<T, Pullback, Slots...>;
  return {value,
          state->append_record(NewRecord<Record>(new Record(std::move(pullback), {std::move(slot)...})))};
}

/// The pullback of a user's operation on a tape of T. Refuses plain numbers on a tape of duals, where they
/// would be constants, so that second derivatives would silently lack a part. Captures cannot be seen from
/// outside; without any, slopes can only be constants.
template <class T, class Pullback>
[[nodiscard]] Pullback accepted(Pullback pullback) {
  static_assert(!DualNumber<T> || std::is_empty_v<Pullback>,
                "on a tape of duals, plain numbers in a pullback are constants and give wrong second "
                "derivatives: compute in the tape's scalar and pass CarriesTangents{pullback}, or give the "
                "tangent to record_tangent()");
  return pullback;
}
template <class T, class Pullback>
[[nodiscard]] Pullback accepted(CarriesTangents<Pullback> stated) {
  return std::move(stated.pullback);
}
}  // namespace detail

template <class Pullback>
CarriesTangents(Pullback) -> CarriesTangents<Pullback>;

/// Records an operation with a scalar result and its pullback on the active tape.
///
/// The inputs are those that the result depends on: Variable<T>, ArrayVariable<T, R> (include record.hpp) or
/// a formula of these. Plain numbers and arrays are allowed, and passive. A std::vector or std::span of
/// inputs is one input, the number of whose parts is known at run time. In the reverse sweep the tape calls
///
///  pullback(T value_adjoint, input_adjoint*...)
///
/// with one pointer an input, in order: T* for a scalar, or Array<T, R>* of the input's extents; null for a
/// passive input; and a std::vector of these pointers for a vector of inputs. The pullback ADDS value_adjoint
/// · d value / d input to each that is not null. Two of them may point to the same adjoint. It is not called
/// when nothing depends on the result. Another reverse() may call it again, so it must keep what it captured;
/// capture values of arrays cheaply as input.shared_value(). On a tape of duals a pullback that captures
/// anything is a CarriesTangents, or does not compile.
///
/// \returns the result; passive, with nothing recorded, when all inputs are passive
/// \throws ShapeError in the reverse sweep if the pullback changes the extents of an input's adjoint
/// \throws DomainError if an input is active but no tape is, or is not on the active tape
template <class T, class Pullback, class... Inputs>
[[nodiscard]] Variable<T> record_scalar(T value, Pullback pullback, const Inputs&... inputs) {
  return detail::record_scalar_slots<T>(value, detail::accepted<T>(std::move(pullback)),
                                        slot_of(detail::SlotFor<T>(), inputs)...);
}

/// Refuses a value that would be a constant on a tape of duals.
template <DualNumber T, std::convertible_to<T> Value, class Pullback, class... Inputs>
requires(!std::same_as<Value, T>) Variable<T> record_scalar(const Value& value, const Pullback&,
                                                            const Inputs&...) {
  static_assert(DualNumber<Value> && std::same_as<Value, T>,
                "on a tape of duals, record_scalar() takes the value as a dual, with its tangents; a plain "
                "number is a constant");
  return T(value);
}
}  // namespace tapestry

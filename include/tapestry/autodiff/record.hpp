#pragma once
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/autodiff/detail/tape/input_slot.hpp>
#include <tapestry/autodiff/variable.hpp>
#include <tapestry/core/array.hpp>

namespace tapestry {
namespace detail {

/// \throws DomainError unless a record of inputs with these links could be made now
template <class T, class... Links>
void require_recordable(const Links&... links) {
  if (!(links.is_active() || ...)) return;
  const TapeState<T>& state = TapeState<T>::require_active();
  (state.require_own_if_active(links), ...);
}

/// Passes a result's adjoint on to the slots of an operation.
/// \throws ShapeError, see ArraySlot::require_shape()
template <class Pullback, class Adjoint, class T, class... Slots>
void pull_back_slots(Pullback& pullback, const Adjoint& adjoint, const std::tuple<Slots...>& all,
                     T* adjoints) {
  std::apply(
      [&](const auto&... slot) {
        pullback(adjoint, slot.adjoint(adjoints)...);
        (slot.require_shape(), ...);
      },
      all);
}

/// Appends the statements of the active inputs among the slots of an operation.
template <class... Slots>
void list_slots(const std::tuple<Slots...>& all, std::vector<std::uint32_t>& statements) {
  std::apply([&](const auto&... slot) { (slot.list(statements), ...); }, all);
}

/// An operation whose result is an array; it owns the result's adjoint.
template <class T, std::size_t Rank>
class ArrayResultRecord : public TapeRecord<T> {
 public:
  explicit ArrayResultRecord(std::shared_ptr<ArrayAdjoint<T, Rank>> adjoint) : adjoint_(std::move(adjoint)) {}
  ArrayResultRecord(const ArrayResultRecord&) = delete;
  ArrayResultRecord& operator=(const ArrayResultRecord&) = delete;
  ~ArrayResultRecord() override { adjoint_->detach(); }
  void pull_back(T* adjoints, std::size_t) final {
    if (!adjoint_->is_touched()) return;
    pull_back_array(adjoint_->read(), adjoints);
    if (adjoint_.use_count() == 1) adjoint_->release();  // consumed, and no variable is left to read it
  }
  void forget_adjoint() noexcept final { adjoint_->forget(); }

 private:
  virtual void pull_back_array(const Array<T, Rank>& adjoint, T* scalar_adjoints) = 0;

  std::shared_ptr<ArrayAdjoint<T, Rank>> adjoint_;
};

/// An operation with a fixed number of inputs of any kinds.
template <class T, std::size_t Rank, class Pullback, class... Slots>
class ArrayRecord final : public ArrayResultRecord<T, Rank> {
 public:
  ArrayRecord(std::shared_ptr<ArrayAdjoint<T, Rank>> adjoint, Pullback pullback, Slots... slot)
      : ArrayResultRecord<T, Rank>(std::move(adjoint)),
        pullback_(std::move(pullback)),
        slots_(std::move(slot)...) {}
  void list_inputs(std::vector<std::uint32_t>& statements) const override { list_slots(slots_, statements); }
  [[nodiscard]] const char* operation() const noexcept override { return detail::type_name<Pullback>(); }

 private:
  void pull_back_array(const Array<T, Rank>& adjoint, T* scalar_adjoints) override {
    pull_back_slots(pullback_, adjoint, slots_, scalar_adjoints);
  }

  Pullback pullback_;
  std::tuple<Slots...> slots_;
};

/// An operation whose result is a scalar.
template <class T, class Pullback, class... Slots>
class ScalarRecord final : public TapeRecord<T> {
 public:
  explicit ScalarRecord(Pullback pullback, Slots... slot)
      : pullback_(std::move(pullback)), slots_(std::move(slot)...) {}
  void pull_back(T* adjoints, std::size_t statement) override {
    const T adjoint = adjoints[statement];
    if (is_zero(adjoint)) return;
    pull_back_slots(pullback_, adjoint, slots_, adjoints);
  }
  void list_inputs(std::vector<std::uint32_t>& statements) const override { list_slots(slots_, statements); }
  [[nodiscard]] const char* operation() const noexcept override { return detail::type_name<Pullback>(); }

 private:
  Pullback pullback_;
  std::tuple<Slots...> slots_;
};

/// An operation whose results are several arrays.
template <class T, std::size_t Rank, class Pullback, class... Slots>
class ArraysRecord final : public TapeRecord<T> {
 public:
  using Adjoints = std::vector<std::shared_ptr<ArrayAdjoint<T, Rank>>>;
  ArraysRecord(Adjoints adjoints, Pullback pullback, Slots... slot)
      : adjoints_(std::move(adjoints)), pullback_(std::move(pullback)), slots_(std::move(slot)...) {}
  ~ArraysRecord() override {
    for (const auto& adjoint : adjoints_) adjoint->detach();
  }
  void pull_back(T* scalar_adjoints, std::size_t) override {
    std::vector<const Array<T, Rank>*> touched;
    bool any = false;
    for (const auto& adjoint : adjoints_) {
      touched.push_back(adjoint->is_touched() ? &adjoint->read() : nullptr);
      any = any || touched.back() != nullptr;
    }
    if (!any) return;
    pull_back_slots(pullback_, touched, slots_, scalar_adjoints);
  }
  void list_inputs(std::vector<std::uint32_t>& statements) const override { list_slots(slots_, statements); }
  [[nodiscard]] const char* operation() const noexcept override { return detail::type_name<Pullback>(); }
  void forget_adjoint() noexcept override {
    for (const auto& adjoint : adjoints_) adjoint->forget();
  }

 private:
  Adjoints adjoints_;
  Pullback pullback_;
  std::tuple<Slots...> slots_;
};

/// Not an operation: a place where the sweep calls a function.
template <class T, class Callback>
class MarkRecord final : public TapeRecord<T> {
 public:
  explicit MarkRecord(Callback passed) : passed_(std::move(passed)) {}
  void pull_back(T*, std::size_t) override { passed_(); }
  void list_inputs(std::vector<std::uint32_t>&) const override {}
  [[nodiscard]] const char* operation() const noexcept override { return detail::type_name<Callback>(); }

 private:
  Callback passed_;
};

template <class T, std::size_t Rank, class Pullback, class... Slots>
[[nodiscard]] ArrayVariable<T, Rank> record_array_slots(std::shared_ptr<const Array<T, Rank>> value,
                                                        Pullback pullback, Slots... slot) {
  TapeState<T>* const state = tape_of<T>(slot...);
  if (state == nullptr) return {std::move(value), nullptr, Link{}};
  auto adjoint = std::make_shared<ArrayAdjoint<T, Rank>>(value->shape(), memory_of(*state));
  using Record = ArrayRecord<T, Rank, Pullback, Slots...>;
  const Link link =
      state->append_record(std::make_unique<Record>(adjoint, std::move(pullback), std::move(slot)...));
  return {std::move(value), std::move(adjoint), link};
}

template <class T, std::size_t Rank, class Pullback, class... Slots>
[[nodiscard]] std::vector<ArrayVariable<T, Rank>> record_arrays_slots(
    std::vector<std::shared_ptr<const Array<T, Rank>>> values, Pullback pullback, Slots... slot) {
  std::vector<ArrayVariable<T, Rank>> results;
  for (auto& value : values) results.emplace_back(std::move(value), nullptr, Link{});
  TapeState<T>* const state = tape_of<T>(slot...);
  if (state == nullptr) return results;
  using Record = ArraysRecord<T, Rank, Pullback, Slots...>;
  typename Record::Adjoints adjoints;
  for (const auto& result : results)
    adjoints.push_back(std::make_shared<ArrayAdjoint<T, Rank>>(result.shape(), memory_of(*state)));
  const Link link =
      state->append_record(std::make_unique<Record>(adjoints, std::move(pullback), std::move(slot)...));
  for (std::size_t i = 0; i < results.size(); ++i)
    results[i] = ArrayVariable<T, Rank>(results[i].shared_value(), adjoints[i], link);
  return results;
}

template <class T, class Pullback, class... Slots>
[[nodiscard]] Variable<T> record_scalar_slots(T value, Pullback pullback, Slots... slot) {
  TapeState<T>* const state = tape_of<T>(slot...);
  if (state == nullptr) return value;
  using Record = ScalarRecord<T, Pullback, Slots...>;
  return {value, state->append_record(std::make_unique<Record>(std::move(pullback), std::move(slot)...))};
}
}  // namespace detail

/// States that a pullback is written for duals: it computes in the scalar of its tape throughout, and
/// captures values with their tangents, or is linear. check_hessian() tests that.
template <class Pullback>
struct CarriesTangents {
  Pullback pullback;
};
template <class Pullback>
CarriesTangents(Pullback) -> CarriesTangents<Pullback>;

namespace detail {
/// The pullback of a user's operation on a tape of T. Refuses plain numbers on a tape of duals, where they
/// would be constants, so that second derivatives would silently lack a part. Captures cannot be seen from
/// outside; without any, slopes can only be constants.
template <class T, class Pullback>
[[nodiscard]] Pullback accepted(Pullback pullback) {
  static_assert(!DualNumber<T> || std::is_empty_v<Pullback>,
                "on a tape of duals, plain numbers in a pullback are constants and give wrong second "
                "derivatives: compute in the tape's scalar and pass CarriesTangents{pullback}");
  return pullback;
}
template <class T, class Pullback>
[[nodiscard]] Pullback accepted(CarriesTangents<Pullback> stated) {
  return std::move(stated.pullback);
}
}  // namespace detail

/// Records an operation with an array result and its pullback on the active tape.
///
/// The inputs are those that the result depends on: ArrayVariable<T, R>, Variable<T> or a formula of these.
/// Plain arrays and numbers are allowed, and passive. A std::vector or std::span of inputs is one input, the
/// number of whose parts is known at run time. In the reverse sweep the tape calls
///
///  pullback(const Array<T, Rank>& value_adjoint, input_adjoint*...)
///
/// with one pointer an input, in order: Array<T, R>* of the input's extents, or T* for a scalar; null for a
/// passive input; and a std::vector of these pointers for a vector of inputs. The pullback ADDS value_adjoint
/// · d value / d input to each that is not null. Two of them may point to the same adjoint. It is not called
/// when nothing depends on the result. Another reverse() may call it again, so it must keep what it captured;
/// capture values of inputs cheaply as input.shared_value(). On a tape of duals a pullback that captures
/// anything is a CarriesTangents, or does not compile.
///
/// \returns the result; passive, with nothing recorded, when all inputs are passive
/// \throws ShapeError in the reverse sweep if the pullback changes the extents of an input's adjoint
/// \throws DomainError if an input is active but no tape is, or is not on the active tape
template <class T, std::size_t Rank, class Pullback, class... Inputs>
[[nodiscard]] ArrayVariable<T, Rank> record_array(Array<T, Rank> value, Pullback pullback,
                                                  const Inputs&... inputs) {
  return detail::record_array_slots<T, Rank>(std::make_shared<const Array<T, Rank>>(std::move(value)),
                                             detail::accepted<T>(std::move(pullback)),
                                             detail::slot_of<T>(inputs)...);
}

/// The same for a result that the pullback reads, too, and therefore shares.
template <class T, std::size_t Rank, class Pullback, class... Inputs>
[[nodiscard]] ArrayVariable<T, Rank> record_array(std::shared_ptr<const Array<T, Rank>> value,
                                                  Pullback pullback, const Inputs&... inputs) {
  return detail::record_array_slots<T, Rank>(std::move(value), detail::accepted<T>(std::move(pullback)),
                                             detail::slot_of<T>(inputs)...);
}

/// The same for several results of one operation, such as the heads of a network. The tape calls
/// pullback(const std::vector<const Array<T, Rank>*>& value_adjoints, input_adjoint*...), where the adjoint
/// of a result that nothing depends on is null.
template <class T, std::size_t Rank, class Pullback, class... Inputs>
[[nodiscard]] std::vector<ArrayVariable<T, Rank>> record_shared_arrays(
    std::vector<std::shared_ptr<const Array<T, Rank>>> values, Pullback pullback, const Inputs&... inputs) {
  return detail::record_arrays_slots<T, Rank>(std::move(values), detail::accepted<T>(std::move(pullback)),
                                              detail::slot_of<T>(inputs)...);
}

/// The same for results without other owners.
template <class T, std::size_t Rank, class Pullback, class... Inputs>
[[nodiscard]] std::vector<ArrayVariable<T, Rank>> record_arrays(std::vector<Array<T, Rank>> values,
                                                                Pullback pullback, const Inputs&... inputs) {
  std::vector<std::shared_ptr<const Array<T, Rank>>> shared;
  for (auto& value : values) shared.push_back(std::make_shared<const Array<T, Rank>>(std::move(value)));
  return record_shared_arrays<T, Rank>(std::move(shared), std::move(pullback), inputs...);
}

/// Records an operation with a scalar result and its pullback on the active tape. Like record_array(), but
/// the tape calls pullback(T value_adjoint, input_adjoint*...), and does not call it when value_adjoint is
/// zero.
template <class T, class Pullback, class... Inputs>
[[nodiscard]] Variable<T> record_scalar(T value, Pullback pullback, const Inputs&... inputs) {
  return detail::record_scalar_slots<T>(value, detail::accepted<T>(std::move(pullback)),
                                        detail::slot_of<T>(inputs)...);
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

/// Puts a mark on the active tape, if there is one: every reverse sweep calls passed() when it reaches the
/// mark. For clocks and progress; no adjoint is involved.
template <class T, class Callback>
void record_mark(Callback passed) {
  if (!detail::TapeState<T>::is_any_active()) return;
  using Record = detail::MarkRecord<T, Callback>;
  static_cast<void>(
      detail::TapeState<T>::require_active().append_record(std::make_unique<Record>(std::move(passed))));
}

}  // namespace tapestry

#pragma once
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/autodiff/detail/tape/record_scalar.hpp>

namespace tapestry {
namespace detail {
/// \throws DomainError unless a record of inputs with these links could be made now
template <class T, class... Links>
void require_recordable(const Links&... links) {
  static_cast<void>(tape_of<T>(InputSlot<T>{links}...));
}

/// An array input of a record. Its adjoint belongs to an earlier record, which the tape forgets later.
template <class T, std::size_t Rank>
struct ArraySlot : InputSlot<T> {
  ArrayAdjoint<T, Rank>* array_adjoint = nullptr;
  [[nodiscard]] Array<T, Rank>* adjoint(T*) const {
    return !this->is_active() ? nullptr : &array_adjoint->touch();
  }
  /// \throws ShapeError if a pullback has put an array of other extents there
  void require_shape() const {
    if (this->is_active() && !array_adjoint->keeps_shape())
      throw ShapeError({"pullback: has changed the extents of the adjoint of an input ",
                        array_adjoint->extents(), "; it must add to it"});
  }
};

template <class T, std::size_t Rank>
[[nodiscard]] ArraySlot<T, Rank> slot_of(SlotFor<T>, const ArrayVariable<T, Rank>& input) {
  if (!input.is_active()) return {};
  return {{input.link()}, input.shared_adjoint().get()};
}
template <class T, std::size_t Rank>
[[nodiscard]] ArraySlot<T, Rank> slot_of(SlotFor<T>, const Array<T, Rank>&) {
  return {};
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
class ArrayRecord final : public CallableRecord<T, ArrayResultRecord<T, Rank>, Pullback, Slots...> {
 public:
  using CallableRecord<T, ArrayResultRecord<T, Rank>, Pullback, Slots...>::CallableRecord;

 private:
  void pull_back_array(const Array<T, Rank>& adjoint, T* scalar_adjoints) override {
    this->call_pullback(adjoint, scalar_adjoints);
  }
};

/// An operation whose results are several arrays.
template <class T, std::size_t Rank, class Pullback, class... Slots>
class ArraysRecord final : public CallableRecord<T, TapeRecord<T>, Pullback, Slots...> {
 public:
  using Adjoints = std::vector<std::shared_ptr<ArrayAdjoint<T, Rank>>>;
  ArraysRecord(Pullback pullback, std::tuple<Slots...> inputs, Adjoints adjoints)
      : CallableRecord<T, TapeRecord<T>, Pullback, Slots...>(std::move(pullback), std::move(inputs)),
        adjoints_(std::move(adjoints)) {}
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
    if (any) this->call_pullback(touched, scalar_adjoints);
  }
  void forget_adjoint() noexcept override {
    for (const auto& adjoint : adjoints_) adjoint->forget();
  }

 private:
  Adjoints adjoints_;
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
  auto adjoint = std::make_shared<ArrayAdjoint<T, Rank>>(value->shape(), lane_of(*state));
  using Record = ArrayRecord<T, Rank, Pullback, Slots...>;
  const Link link = state->append_record(
      std::make_unique<Record>(std::move(pullback), std::tuple<Slots...>(std::move(slot)...), adjoint));
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
    adjoints.push_back(std::make_shared<ArrayAdjoint<T, Rank>>(result.shape(), lane_of(*state)));
  const Link link = state->append_record(
      std::make_unique<Record>(std::move(pullback), std::tuple<Slots...>(std::move(slot)...), adjoints));
  for (std::size_t i = 0; i < results.size(); ++i)
    results[i] = ArrayVariable<T, Rank>(results[i].shared_value(), adjoints[i], link);
  return results;
}
}  // namespace detail

/// Records an operation with an array result and its pullback on the active tape. Like record_scalar(), but
/// the tape calls pullback(const Array<T, Rank>& value_adjoint, input_adjoint*...).
template <class T, std::size_t Rank, class Pullback, class... Inputs>
[[nodiscard]] ArrayVariable<T, Rank> record_array(std::shared_ptr<const Array<T, Rank>> value,
                                                  Pullback pullback, const Inputs&... inputs) {
  return detail::record_array_slots<T, Rank>(std::move(value), detail::accepted<T>(std::move(pullback)),
                                             slot_of(detail::SlotFor<T>(), inputs)...);
}

/// The same for a result that the pullback does not share.
template <class T, std::size_t Rank, class Pullback, class... Inputs>
[[nodiscard]] ArrayVariable<T, Rank> record_array(Array<T, Rank> value, Pullback pullback,
                                                  const Inputs&... inputs) {
  return record_array<T, Rank>(std::make_shared<const Array<T, Rank>>(std::move(value)), std::move(pullback),
                               inputs...);
}

/// The same for several results of one operation, such as the heads of a network. The tape calls
/// pullback(const std::vector<const Array<T, Rank>*>& value_adjoints, input_adjoint*...), where the adjoint
/// of a result that nothing depends on is null.
template <class T, std::size_t Rank, class Pullback, class... Inputs>
[[nodiscard]] std::vector<ArrayVariable<T, Rank>> record_shared_arrays(
    std::vector<std::shared_ptr<const Array<T, Rank>>> values, Pullback pullback, const Inputs&... inputs) {
  return detail::record_arrays_slots<T, Rank>(std::move(values), detail::accepted<T>(std::move(pullback)),
                                              slot_of(detail::SlotFor<T>(), inputs)...);
}

/// The same for results without other owners.
template <class T, std::size_t Rank, class Pullback, class... Inputs>
[[nodiscard]] std::vector<ArrayVariable<T, Rank>> record_arrays(std::vector<Array<T, Rank>> values,
                                                                Pullback pullback, const Inputs&... inputs) {
  std::vector<std::shared_ptr<const Array<T, Rank>>> shared;
  for (auto& value : values) shared.push_back(std::make_shared<const Array<T, Rank>>(std::move(value)));
  return record_shared_arrays<T, Rank>(std::move(shared), std::move(pullback), inputs...);
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

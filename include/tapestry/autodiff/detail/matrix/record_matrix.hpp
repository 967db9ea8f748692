#pragma once
#include <tapestry/autodiff/detail/matrix/matrix_input.hpp>

/// Conversion of an operation on matrices to one record, whichever way its matrices are held.
namespace tapestry::detail {
template <class Target>
[[nodiscard]] bool is_wanted(const Target& adjoint) {
  if constexpr (std::is_pointer_v<Target>) {
    return adjoint != nullptr;
  } else {
    return !adjoint.links->empty();
  }
}
template <class T, std::size_t Rank>
void add_part(Array<T, Rank>* adjoint, const DenseMatrix<T>& part) {
  Eigen::Map<RowMajorMatrix<T>>(adjoint->data(), part.rows(), part.cols()) += part;
}
template <class T>
void add_part(const typename EntriesSlot<T>::Adjoint& adjoint, const DenseMatrix<T>& part) {
  const std::vector<Link>& links = *adjoint.links;
  for (std::size_t i = 0; i < links.size(); ++i)
    if (links[i].is_active()) adjoint.adjoints[links[i].index()] += part.data()[i];
}

template <class T>
[[nodiscard]] const T& as_dense(const T& scalar) {
  return scalar;
}
template <class T, std::size_t Rank>
[[nodiscard]] DenseMatrix<T> as_dense(const Array<T, Rank>& array) {
  return eigen_map(array);
}

/// Runs pullback(value_adjoint, DenseMatrix<T>*...), which assigns to plain matrices, and adds these to
/// adjoints of any kind; the pointer is null for a passive input.
template <class T, class Pullback>
struct MatrixPullback {
  Pullback pullback;

  template <class Adjoint, class... Targets>
  void operator()(const Adjoint& value_adjoint, const Targets&... targets) const {
    call(value_adjoint, std::index_sequence_for<Targets...>(), targets...);
  }

 private:
  template <class Adjoint, std::size_t... Index, class... Targets>
  void call(const Adjoint& value_adjoint, std::index_sequence<Index...>, const Targets&... targets) const {
    std::array<DenseMatrix<T>, sizeof...(Index)> parts;
    pullback(as_dense(value_adjoint), (is_wanted(targets) ? &parts[Index] : nullptr)...);
    (add_if_wanted(targets, parts[Index]), ...);
  }
  template <class Target>
  static void add_if_wanted(const Target& target, const DenseMatrix<T>& part) {
    if (is_wanted(target)) add_part<T>(target, part);
  }
};

/// An operation whose result is an Eigen matrix of variables, which are the statements behind it, column by
/// column.
template <class T, class Pullback, class... Slots>
class EntriesRecord final : public CallableRecord<T, TapeRecord<T>, Pullback, Slots...> {
 public:
  EntriesRecord(Pullback pullback, std::tuple<Slots...> inputs, Eigen::Index rows, Eigen::Index columns)
      : CallableRecord<T, TapeRecord<T>, Pullback, Slots...>(std::move(pullback), std::move(inputs)),
        rows_(rows),
        columns_(columns) {}
  void pull_back(T* adjoints, std::size_t statement) override {
    const T* const first = adjoints + statement + 1;
    if (std::all_of(first, first + rows_ * columns_, [](const T& adjoint) { return is_zero(adjoint); }))
      return;
    const DenseMatrix<T> value_adjoint = Eigen::Map<const DenseMatrix<T>>(first, rows_, columns_);
    this->call_pullback(value_adjoint, adjoints);
  }

 private:
  Eigen::Index rows_, columns_;
};

template <std::size_t Rank, class T>
[[nodiscard]] std::shared_ptr<const Array<T, Rank>> shared_array_of(const DenseMatrix<T>& value) {
  Extents<Rank> extents{static_cast<std::size_t>(value.rows())};
  if constexpr (Rank == 2) extents[1] = static_cast<std::size_t>(value.cols());
  auto array = std::make_shared<Array<T, Rank>>(extents);
  Eigen::Map<RowMajorMatrix<T>>(array->data(), value.rows(), value.cols()) = value;
  return array;
}

template <int Columns, class T, class Pullback, class... Slots>
[[nodiscard]] Eigen::Matrix<Variable<T>, Eigen::Dynamic, Columns> record_entries(const DenseMatrix<T>& value,
                                                                                 Pullback pullback,
                                                                                 Slots... slot) {
  Eigen::Matrix<Variable<T>, Eigen::Dynamic, Columns> result = value.template cast<Variable<T>>();
  TapeState<T>* const state = tape_of<T>(slot...);
  if (state == nullptr) return result;
  using Record = EntriesRecord<T, Pullback, Slots...>;
  const auto size = static_cast<std::size_t>(value.size());
  static_cast<void>(state->append_record(
      std::make_unique<Record>(std::move(pullback), std::tuple<Slots...>(std::move(slot)...), value.rows(),
                               value.cols()),
      size));
  for (std::size_t i = 0; i < size;) {
    std::size_t count = size - i;
    Link link = state->append_inputs(count);
    for (const std::size_t end = i + count; i < end; ++i, ++link) result.data()[i] = {value.data()[i], link};
  }
  return result;
}

template <class Slot>
inline constexpr bool is_array_slot = false;
template <class T, std::size_t Rank>
inline constexpr bool is_array_slot<ArraySlot<T, Rank>> = true;

/// The result of an operation: an array if an input is one, else an Eigen matrix; a vector if Columns is 1.
/// \param pullback  called with (const DenseMatrix<T>& value_adjoint, DenseMatrix<T>*...), see MatrixPullback
template <int Columns, class T, class Pullback, class... Slots>
[[nodiscard]] auto record_matrix(const DenseMatrix<T>& value, Pullback pullback,
                                 MatrixInput<T, Slots>... inputs) {
  MatrixPullback<T, Pullback> adding{std::move(pullback)};
  if constexpr ((is_array_slot<Slots> || ...)) {
    constexpr std::size_t rank = Columns == 1 ? 1 : 2;
    return record_array_slots<T, rank>(shared_array_of<rank>(value), std::move(adding),
                                       std::move(inputs.slot)...);
  } else {
    return record_entries<Columns, T>(value, std::move(adding), std::move(inputs.slot)...);
  }
}

/// The same for a number. \param pullback  called with (T value_adjoint, DenseMatrix<T>*...)
template <class T, class Pullback, class... Slots>
[[nodiscard]] Variable<T> record_number(T value, Pullback pullback, MatrixInput<T, Slots>... inputs) {
  return record_scalar_slots<T>(value, MatrixPullback<T, Pullback>{std::move(pullback)},
                                std::move(inputs.slot)...);
}
}  // namespace tapestry::detail

#pragma once
#include <tapestry/autodiff/detail/arrays/reduction.hpp>

namespace tapestry {
/// One element as a scalar. \throws ShapeError if the index lies outside
template <class T, std::size_t Rank>
[[nodiscard]] Variable<T> element(const ArrayVariable<T, Rank>& x, const Extents<Rank>& index) {
  std::size_t place = 0;
  for (std::size_t axis = 0; axis < Rank; ++axis) {
    if (index[axis] >= x.shape()[axis])
      throw ShapeError({"element: index ", index, " lies outside ", x.shape()});
    place = place * x.shape()[axis] + index[axis];
  }
  const auto pullback = [place](T value_adjoint, Array<T, Rank>* x_adjoint) {
    x_adjoint->data()[place] += value_adjoint;
  };
  return record_scalar(x.value().data()[place], CarriesTangents{pullback}, x);
}

/// The same elements in row-major order under other extents. \throws ShapeError if their number differs
template <std::size_t NewRank, DifferentiableArray X>
[[nodiscard]] auto reshape(const X& x, const Extents<NewRank>& extents) {
  using T = detail::ArrayScalarType<X>;
  const ArrayVariable<T, X::rank> variable(x);
  if (detail::count_of(extents) != variable.size())
    throw ShapeError({"reshape: ", variable.shape(), " does not fit ", extents});
  Array<T, NewRank> value(extents);
  std::copy_n(variable.value().data(), variable.size(), value.data());
  const auto pullback = [](const Array<T, NewRank>& value_adjoint, Array<T, X::rank>* x_adjoint) {
    for (std::size_t i = 0; i < value_adjoint.size(); ++i) x_adjoint->data()[i] += value_adjoint.data()[i];
  };
  return record_array(std::move(value), CarriesTangents{pullback}, variable);
}

namespace detail {
inline void require_places(const char* operation, const std::vector<std::size_t>& places, std::size_t size) {
  for (const std::size_t place : places)
    if (place >= size) throw ShapeError({operation, ": index ", place, " lies outside [", size, "]"});
}
}  // namespace detail

/// Elements of x by their row-major places, [places]; a place may be named more than once.
/// \throws ShapeError if a place lies outside
template <DifferentiableArray X>
[[nodiscard]] auto gather(const X& x, std::vector<std::size_t> places) {
  using T = detail::ArrayScalarType<X>;
  const ArrayVariable<T, X::rank> variable(x);
  detail::require_places("gather", places, variable.size());
  Array<T, 1> value(Extents<1>{places.size()});
  for (std::size_t i = 0; i < places.size(); ++i) value.data()[i] = variable.value().data()[places[i]];
  const auto pullback = [from = std::move(places)](const Array<T, 1>& value_adjoint,
                                                   Array<T, X::rank>* x_adjoint) {
    for (std::size_t i = 0; i < from.size(); ++i) x_adjoint->data()[from[i]] += value_adjoint.data()[i];
  };
  return record_array(std::move(value), CarriesTangents{pullback}, variable);
}

/// Adds element i of x, in row-major order, at places[i] of an array of zeros.
/// \throws ShapeError if a place lies outside, or their number is not that of the elements
template <std::size_t Rank, DifferentiableArray X>
[[nodiscard]] auto scatter(const X& x, std::vector<std::size_t> places, const Extents<Rank>& extents) {
  using T = detail::ArrayScalarType<X>;
  const ArrayVariable<T, X::rank> variable(x);
  if (places.size() != variable.size())
    throw ShapeError({"scatter: ", places.size(), " places for ", variable.shape()});
  detail::require_places("scatter", places, detail::count_of(extents));
  Array<T, Rank> value = zeros<T, Rank>(extents);
  for (std::size_t i = 0; i < places.size(); ++i) value.data()[places[i]] += variable.value().data()[i];
  const auto pullback = [to = std::move(places)](const Array<T, Rank>& value_adjoint,
                                                 Array<T, X::rank>* x_adjoint) {
    for (std::size_t i = 0; i < to.size(); ++i) x_adjoint->data()[i] += value_adjoint.data()[to[i]];
  };
  return record_array(std::move(value), CarriesTangents{pullback}, variable);
}
}  // namespace tapestry

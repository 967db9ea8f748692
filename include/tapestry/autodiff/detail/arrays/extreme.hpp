#pragma once
#include <tapestry/autodiff/detail/arrays/reduction.hpp>

namespace tapestry {
namespace detail {
/// The best element of each line, the first of equals; the adjoint goes to that element.
template <class X, class IsBetter>
[[nodiscard]] auto extreme_along(const char* operation, const X& x, std::size_t axis, IsBetter is_better) {
  using T = ArrayScalarType<X>;
  constexpr std::size_t rank = X::rank;
  const ArrayVariable<T, rank> variable(x);
  const auto layout = layout_around(operation, variable.shape(), axis);
  Array<T, rank - 1> value(without_axis(variable.shape(), axis));
  if (layout.count == 0 && value.size() > 0)
    throw ShapeError({operation, ": no elements along axis ", axis, " of ", variable.shape()});
  std::vector<std::size_t> places(value.size());
  const T* const from = variable.value().data();
  for_each_line(layout, [&](std::size_t first, std::size_t line) {
    std::size_t best = first;
    for (std::size_t i = 1; i < layout.count; ++i)
      if (const std::size_t place = first + i * layout.inner; is_better(from[place], from[best]))
        best = place;
    places[line] = best;
    value.data()[line] = from[best];
  });
  auto pullback = [places = std::move(places)](const Array<T, rank - 1>& value_adjoint,
                                               Array<T, rank>* x_adjoint) {
    for (std::size_t line = 0; line < places.size(); ++line)
      x_adjoint->data()[places[line]] += value_adjoint.data()[line];
  };
  return record_array(std::move(value), CarriesTangents{std::move(pullback)}, variable);
}
}  // namespace detail

/// The largest element along one axis, which is dropped: the first of several equal ones, or the first NaN.
/// The adjoint goes to that element.
/// \throws ShapeError if there is no such axis, or no elements along it
template <DifferentiableArray X>
[[nodiscard]] auto largest_along(const X& x, std::size_t axis) {
  return detail::extreme_along("largest_along", x, axis,
                               [](auto a, auto b) { return detail::is_beyond(a > b, a, b); });
}

/// The smallest one; otherwise as largest_along().
template <DifferentiableArray X>
[[nodiscard]] auto smallest_along(const X& x, std::size_t axis) {
  return detail::extreme_along("smallest_along", x, axis,
                               [](auto a, auto b) { return detail::is_beyond(a < b, a, b); });
}

/// The mean along one axis, which is dropped, added in double; NaN without elements.
/// \throws ShapeError if there is no such axis
template <DifferentiableArray X>
[[nodiscard]] auto mean_along(const X& x, std::size_t axis) {
  using T = detail::ArrayScalarType<X>;
  const auto total = sum_along(x, axis);
  return ArrayVariable<T, X::rank - 1>(total / static_cast<detail::Base<T>>(x.shape()[axis]));
}
}  // namespace tapestry

#pragma once
#include <tapestry/autodiff/detail/arrays/adjoint_lane.hpp>  // count_of

namespace tapestry::detail {
/// Steps between elements along each axis, in elements.
template <std::size_t Rank>
using Strides = std::array<std::ptrdiff_t, Rank>;

template <std::size_t Rank>
[[nodiscard]] Strides<Rank> row_major_strides(const Extents<Rank>& extents) {
  Strides<Rank> strides{};
  std::ptrdiff_t step = 1;
  for (std::size_t axis = Rank; axis-- > 0;) {
    strides[axis] = step;
    step *= static_cast<std::ptrdiff_t>(extents[axis]);
  }
  return strides;
}

/// The extents of two operands together: an axis of extent 1 repeats along the other's.
template <std::size_t Rank>
[[nodiscard]] Extents<Rank> broadcast_extents(const char* operation, const Extents<Rank>& x,
                                              const Extents<Rank>& y, const char* argument) {
  Extents<Rank> together{};
  for (std::size_t axis = 0; axis < Rank; ++axis) {
    if (x[axis] != y[axis] && x[axis] != 1 && y[axis] != 1)
      throw ShapeError({operation, ": ", argument, " is ", y, ", expected ", x});
    together[axis] = x[axis] == 1 ? y[axis] : x[axis];
  }
  return together;
}

/// How an expression's elements are visited: rows of `length` elements, in row-major order. The axes from
/// `row_axes` on are one row, because every operand steps through them as through one axis.
template <std::size_t Rank>
struct RowPlan {
  Extents<Rank> extents{};
  std::size_t row_axes = 0;
  std::size_t length = 1;
  std::size_t size = 1;

  /// \param joins  whether axes a and a + 1 are one to all operands
  template <class Joins>
  RowPlan(const Extents<Rank>& all, Joins joins) : extents(all), size(count_of(all)) {
    if constexpr (Rank > 0) {
      row_axes = Rank - 1;
      length = extents[Rank - 1];
      while (row_axes > 0 && joins(row_axes - 1)) length *= extents[--row_axes];
    }
  }

  /// Calls visit(index of the row's first element, its position) for each row.
  template <class Visit>
  void for_each_row(Visit visit) const {
    if (size == 0) return;
    Extents<Rank> index{};
    for (std::size_t position = 0; position < size; position += length) {
      visit(index, position);
      for (std::size_t axis = row_axes; axis-- > 0;) {
        if (++index[axis] < extents[axis]) break;
        index[axis] = 0;
      }
    }
  }
};
}  // namespace tapestry::detail

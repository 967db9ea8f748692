#pragma once
#include <tapestry/autodiff/detail/arrays/expression/node.hpp>

namespace tapestry {
/// Elements first, first + step … below last along one axis; all of them by default.
struct Range {
  std::size_t first = 0;
  std::size_t last = std::numeric_limits<std::size_t>::max();  ///< the axis's end, if beyond it
  std::size_t step = 1;
};

namespace detail {
[[noreturn]] inline void throw_outside(const char* operation, std::size_t found, std::size_t axis,
                                       std::size_t extent) {
  throw ShapeError({operation, ": ", found, " along axis ", axis, ", expected at most ", extent});
}

template <class T, std::size_t Rank>
[[nodiscard]] auto view_of(const ArrayVariable<T, Rank>& x) {
  return whole_view(x);
}
template <class T, std::size_t Whole, std::size_t Rank>
[[nodiscard]] const ArrayView<T, Whole, Rank>& view_of(const ArrayView<T, Whole, Rank>& x) {
  return x;
}
}  // namespace detail

/// An array variable, or a view of one.
template <class X>
concept Viewable = requires(const X& x) {
  detail::view_of(x);
};

// Views of arrays, to be used in formulas without copying: their elements are read, and their adjoints added,
// where they lie.
// \throws ShapeError if they would leave the array; but the end of a range beyond its axis is cut to it.

/// A range of each axis.
template <Viewable X>
[[nodiscard]] auto slice(const X& x, const std::array<Range, X::rank>& ranges) {
  auto view = detail::view_of(x);
  Extents<X::rank> extents{};
  detail::Strides<X::rank> strides = view.strides();
  std::ptrdiff_t offset = view.offset();
  for (std::size_t axis = 0; axis < X::rank; ++axis) {
    const std::size_t extent = view.shape()[axis], last = std::min(ranges[axis].last, extent);
    const auto [first, unused, step] = ranges[axis];
    if (first > last) detail::throw_outside("slice", first, axis, last);
    if (step == 0) throw ShapeError({"slice: step 0 along axis ", axis});
    extents[axis] = (last - first + step - 1) / step;
    offset += static_cast<std::ptrdiff_t>(first) * strides[axis];
    strides[axis] *= static_cast<std::ptrdiff_t>(step);
  }
  return decltype(view)(view.whole(), offset, extents, strides);
}

/// Elements at `index` of one axis, which is dropped: column(matrix, j) is select(matrix, 1, j).
template <Viewable X>
[[nodiscard]] auto select(const X& x, std::size_t axis, std::size_t index) {
  const auto view = detail::view_of(x);
  if (axis >= X::rank || index >= view.shape()[axis])
    detail::throw_outside("select", index, axis, axis < X::rank ? view.shape()[axis] - 1 : 0);
  Extents<X::rank - 1> extents{};
  detail::Strides<X::rank - 1> strides{};
  for (std::size_t to = 0; to + 1 < X::rank; ++to) {
    const std::size_t from = to < axis ? to : to + 1;
    extents[to] = view.shape()[from];
    strides[to] = view.strides()[from];
  }
  const auto offset = view.offset() + static_cast<std::ptrdiff_t>(index) * view.strides()[axis];
  using Whole = std::remove_cvref_t<decltype(view.whole())>;
  return ArrayView<typename Whole::value_type, Whole::rank, X::rank - 1>(view.whole(), offset, extents,
                                                                         strides);
}

/// Column j of a matrix.
template <Viewable X>
requires(X::rank == 2) [[nodiscard]] auto column(const X& x, std::size_t j) { return select(x, 1, j); }

/// The axes in another order: axis a of the view is axis order[a] of x.
template <Viewable X>
[[nodiscard]] auto transpose(const X& x, const std::array<std::size_t, X::rank>& order) {
  auto view = detail::view_of(x);
  Extents<X::rank> extents{};
  detail::Strides<X::rank> strides{};
  std::array<bool, X::rank> seen{};
  for (std::size_t axis = 0; axis < X::rank; ++axis) {
    if (order[axis] >= X::rank || seen[order[axis]])
      throw ShapeError({"transpose: ", order, " is no order of the axes"});
    seen[order[axis]] = true;
    extents[axis] = view.shape()[order[axis]];
    strides[axis] = view.strides()[order[axis]];
  }
  return decltype(view)(view.whole(), view.offset(), extents, strides);
}

/// The transposed matrix.
template <Viewable X>
requires(X::rank == 2) [[nodiscard]] auto transpose(const X& x) { return transpose(x, {1, 0}); }

/// Repeats x along an axis put before `axis`: extent 1 to repeat as far as the operand beside it, or `count`.
template <Viewable X>
[[nodiscard]] auto repeat(const X& x, std::size_t axis, std::size_t count = 1) {
  const auto view = detail::view_of(x);
  if (axis > X::rank) detail::throw_outside("repeat", axis, axis, X::rank);
  Extents<X::rank + 1> extents{};
  detail::Strides<X::rank + 1> strides{};
  for (std::size_t from = 0; from < X::rank; ++from) {
    const std::size_t to = from < axis ? from : from + 1;
    extents[to] = view.shape()[from];
    strides[to] = view.strides()[from];
  }
  extents[axis] = count;
  using Whole = std::remove_cvref_t<decltype(view.whole())>;
  return ArrayView<typename Whole::value_type, Whole::rank, X::rank + 1>(view.whole(), view.offset(), extents,
                                                                         strides);
}

/// x at larger extents: an axis of extent 1 repeats.
template <Viewable X>
[[nodiscard]] auto broadcast(const X& x, const Extents<X::rank>& extents) {
  auto view = detail::view_of(x);
  for (std::size_t axis = 0; axis < X::rank; ++axis)
    if (view.shape()[axis] != extents[axis] && view.shape()[axis] != 1)
      throw ShapeError({"broadcast: ", view.shape(), " does not repeat to ", extents});
  return decltype(view)(view.whole(), view.offset(), extents, view.strides_in(extents));
}
}  // namespace tapestry

#pragma once
#include <algorithm>
#include <concepts>
#include <tapestry/core/detail/supported_target.hpp>
#include <tapestry/core/platform/memory.hpp>
#include <tuple>

namespace tapestry {
/// Array whose number of axes is fixed at compile time and whose elements are float or double.
template <class T, std::size_t Rank>
concept RealArray = std::floating_point<typename T::value_type> && std::tuple_size_v<typename T::shape_type>
== Rank;

/// Axes are row, column, channel.
template <class T>
concept Image = RealArray<T, 3>;

/// Axes are row, column.
template <class T>
concept Mask = RealArray<T, 2>;
}  // namespace tapestry

// C's <complex.h> defines I, and xtensor has parameters of this name.
#pragma push_macro("I")
#undef I
#if __has_include(<xtensor/containers/xtensor.hpp>)  // 0.26 moved its headers into folders
#include <xtensor/containers/xtensor.hpp>
#else
#include <xtensor/xtensor.hpp>
#endif
#pragma pop_macro("I")

namespace tapestry {
/// The array type of Tapestry's interfaces: row-major, owning, number of axes fixed; large ones in memory
/// that platform::PagePool keeps. An array of another allocator becomes one by Array<T, Rank>(other).
template <class T, std::size_t Rank>
using Array = xt::xtensor<T, Rank, xt::layout_type::row_major, platform::PageAllocator<T>>;

template <std::size_t Rank>
using Extents = std::array<std::size_t, Rank>;

/// Array of the given extents filled with one value.
template <class T, std::size_t Rank>
[[nodiscard]] Array<T, Rank> filled(const Extents<Rank>& extents, T value) {
  Array<T, Rank> array(extents);
  for (T& element : array.storage()) element = value;
  return array;
}

/// Array of the given extents filled with zeros.
template <class T, std::size_t Rank>
[[nodiscard]] Array<T, Rank> zeros(const Extents<Rank>& extents) {
  return filled<T, Rank>(extents, T(0));
}

/// The values as an array of one axis.
template <class T>
[[nodiscard]] Array<T, 1> array_of(const std::vector<T>& values) {
  Array<T, 1> array(Extents<1>{values.size()});
  std::copy(values.begin(), values.end(), array.data());
  return array;
}

/// The same numbers in another precision, without a copy if it is the same.
template <class To, class From, std::size_t Rank>
[[nodiscard]] Array<To, Rank> cast(Array<From, Rank> from) {
  if constexpr (std::is_same_v<To, From>) return from;
  Array<To, Rank> to(from.shape());
  for (std::size_t i = 0; i < from.size(); ++i) to.data()[i] = static_cast<To>(from.data()[i]);
  return to;
}
}  // namespace tapestry

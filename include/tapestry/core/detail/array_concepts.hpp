#pragma once
#include <concepts>
#include <cstddef>
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

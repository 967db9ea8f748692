#pragma once
#include <tapestry/core/array.hpp>
#include <tapestry/core/random.hpp>

namespace tapestry::test {
/// Values in [low, high), the same on every platform for a given seed.
template <class Scalar, std::size_t Rank>
Array<Scalar, Rank> random_array(const std::size_t (&extents)[Rank], std::uint64_t seed, double low = 0,
                                 double high = 1) {
  Extents<Rank> shape{};
  for (std::size_t axis = 0; axis < Rank; ++axis) shape[axis] = extents[axis];
  Array<Scalar, Rank> array(shape);
  Random random(seed);
  for (auto& value : array.storage()) value = static_cast<Scalar>(random.uniform(low, high));
  return array;
}

/// Random array of Euclidean length one.
template <class Scalar, std::size_t Rank>
Array<Scalar, Rank> random_direction(const std::size_t (&extents)[Rank], std::uint64_t seed) {
  auto array = random_array<Scalar>(extents, seed, -1, 1);
  double squared_length = 0;
  for (const auto value : array.storage())
    squared_length += static_cast<double>(value) * static_cast<double>(value);
  for (auto& value : array.storage()) value /= static_cast<Scalar>(std::sqrt(squared_length));
  return array;
}
}  // namespace tapestry::test

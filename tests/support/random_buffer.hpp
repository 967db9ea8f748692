#pragma once
#include <tapestry/core/random.hpp>
#include <tapestry/nn/workspace.hpp>

namespace tapestry::test {
/// Values in [−1, 1).
template <class T>
nn::Buffer<T> random_buffer(std::size_t count, std::uint64_t seed) {
  nn::Buffer<T> buffer(count);
  Random random(seed);
  T* const values = buffer.data();
  for (std::size_t i = 0; i < count; ++i) values[i] = static_cast<T>(random.uniform(-1, 1));
  return buffer;
}
}  // namespace tapestry::test

#pragma once
#include <concepts>
#include <cstddef>
#include <tapestry/core/parallel.hpp>
#include <tapestry/nn/activation.hpp>
#include <tapestry/nn/vector_kernels.hpp>

namespace tapestry::nn {
namespace detail {
inline constexpr std::size_t pointwise_block = 65536;

template <class Body>
void for_each_block(std::size_t count, Body body) {
  parallel_for(block_count(count, pointwise_block), [&](std::size_t i) {
    const BlockRange range = block_range(i, count, pointwise_block);
    body(range.begin, range.end - range.begin);
  });
}
}  // namespace detail

/// to[i] += from[i]
template <std::floating_point T>
void add(const T* from, T* to, std::size_t count) {
  detail::for_each_block(
      count, [&](std::size_t begin, std::size_t size) { kernels<T>().add(from + begin, to + begin, size); });
}

/// values[i] = activation(values[i])
template <std::floating_point T>
void activate(Activation activation, T* values, std::size_t count) {
  if (activation == Activation::linear) return;
  detail::for_each_block(count, [&](std::size_t begin, std::size_t size) {
    for (std::size_t i = begin; i < begin + size; ++i) values[i] = activate(activation, values[i]);
  });
}

/// True if an activation's slope needs its argument; otherwise its result is enough.
[[nodiscard]] constexpr bool slope_needs_argument(Activation activation) {
  return activation == Activation::swish || activation == Activation::mish;
}

/// adjoint[i] *= activation'(argument), where `kept` is the argument if slope_needs_argument(), else the
/// result.
template <std::floating_point T>
void activation_adjoint(Activation activation, const T* kept, T* adjoint, std::size_t count) {
  if (activation == Activation::linear) return;
  detail::for_each_block(count, [&](std::size_t begin, std::size_t size) {
    if (is_piecewise_linear(activation)) {
      kernels<T>().leaky_adjoint(kept + begin, negative_slope<T>(activation), adjoint + begin, size);
      return;
    }
    for (std::size_t i = begin; i < begin + size; ++i)
      adjoint[i] *= activation == Activation::logistic ? kept[i] * (1 - kept[i])
                                                       : activation_slope(activation, kept[i]);
  });
}

}  // namespace tapestry::nn

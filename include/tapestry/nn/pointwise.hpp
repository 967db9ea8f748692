#pragma once
#include <cstring>
#include <tapestry/nn/convolution_geometry.hpp>
#include <tapestry/nn/detail/vector_kernels.hpp>

namespace tapestry::nn {
namespace detail {
inline constexpr std::size_t pointwise_block = 65536;

template <class Body>
void for_each_block(std::size_t count, Body body) {
  parallel_for_blocks(count, pointwise_block,
                      [&](std::size_t begin, std::size_t end) { body(begin, end - begin); });
}
}  // namespace detail

/// to[i] = from[i]
template <std::floating_point T>
void copy(const T* from, T* to, std::size_t count) {
  detail::for_each_block(count, [&](std::size_t begin, std::size_t size) {
    std::memcpy(to + begin, from + begin, size * sizeof(T));
  });
}

/// to[i] += from[i]
template <std::floating_point T>
void add(const T* from, T* to, std::size_t count) {
  detail::for_each_block(
      count, [&](std::size_t begin, std::size_t size) { kernels<T>().add(from + begin, to + begin, size); });
}

/// to[i] *= from[i]
template <std::floating_point T>
void multiply(const T* from, T* to, std::size_t count) {
  detail::for_each_block(count, [&](std::size_t begin, std::size_t size) {
    kernels<T>().multiply(from + begin, to + begin, size);
  });
}

/// to[i] = curve(from[i]), slopes[i] = curve'(from[i]) unless null. `from` and `to` may be the same.
template <std::floating_point T>
void apply_curve(const Curve<T>& curve, const T* from, T* to, std::size_t count, T* slopes = nullptr) {
  detail::for_each_block(count, [&](std::size_t begin, std::size_t size) {
    kernels<T>().apply_curve(curve, from + begin, to + begin, slopes == nullptr ? nullptr : slopes + begin,
                             size);
  });
}

/// Bit i mod 8 of bits[i / 8] becomes whether values[i] is above 0. NaN is not.
template <std::floating_point T>
void positive_bits(const T* values, std::uint8_t* bits, std::size_t count) {
  detail::for_each_block(count, [&](std::size_t begin, std::size_t size) {
    kernels<T>().positive_bits(values + begin, bits + begin / 8, size);
  });
}

/// to[i] = from[i], times slope where bit i of positive_bits() is not set. Both may be the same.
template <std::floating_point T>
void leaky_adjoint(const std::uint8_t* bits, T slope, const T* from, T* to, std::size_t count) {
  detail::for_each_block(count, [&](std::size_t begin, std::size_t size) {
    kernels<T>().leaky_adjoint(bits + begin / 8, slope, from + begin, to + begin, size);
  });
}

/// True if a convolution can write and read the bits of its own output: all its vectors of channels, which
/// end with a group, are full.
template <std::floating_point T>
[[nodiscard]] bool fuses_bits(const ConvolutionShape& shape) {
  const std::size_t lanes = kernels<T>().lanes;
  const std::size_t side_by_side = shape.is_depthwise() ? shape.out_channels : shape.group_out();
  return lanes % 8 == 0 && side_by_side % lanes == 0;
}
}  // namespace tapestry::nn

#pragma once
#include <algorithm>
#include <cstddef>
#include <cstring>
#include <tapestry/core/parallel.hpp>
#include <tapestry/detect/network_config.hpp>
#include <tapestry/nn/vector_kernels.hpp>

namespace tapestry::detect::detail {

/// Copies channels between activations: `count` channels of [pixels, from_pitch] to [pixels, to_pitch].
template <class T>
void copy_channels(const T* from, std::size_t from_pitch, T* to, std::size_t to_pitch, std::size_t count,
                   std::size_t pixels, bool adds) {
  constexpr std::size_t block = 1024;
  parallel_for(block_count(pixels, block), [&](std::size_t b) {
    const BlockRange range = block_range(b, pixels, block);
    for (std::size_t p = range.begin; p < range.end; ++p) {
      if (adds) {
        nn::kernels<T>().add(from + p * from_pitch, to + p * to_pitch, count);
      } else {
        std::memcpy(to + p * to_pitch, from + p * from_pitch, count * sizeof(T));
      }
    }
  });
}

/// Adds what a shortcut of unequal activations adds: as many channels as the fewer are, and of the one that
/// has f times the pixels along both axes each f-th, from the first. Source: shortcut_cpu of pjreddie's
/// Darknet.
template <class T>
void add_shared(std::size_t images, const FeatureShape& from_shape, const T* from,
                const FeatureShape& to_shape, T* to) {
  const std::size_t rows = std::min(from_shape.height, to_shape.height);
  const std::size_t columns = std::min(from_shape.width, to_shape.width);
  const auto offset = [&](const FeatureShape& shape, std::size_t task, std::size_t column) {
    const std::size_t row = task / rows * shape.height + task % rows * (shape.height / rows);
    return (row * shape.width + column * (shape.width / columns)) * shape.channels;
  };
  parallel_for(images * rows, [&](std::size_t task) {
    for (std::size_t column = 0; column < columns; ++column)
      nn::kernels<T>().add(from + offset(from_shape, task, column), to + offset(to_shape, task, column),
                           std::min(from_shape.channels, to_shape.channels));
  });
}

}  // namespace tapestry::detect::detail

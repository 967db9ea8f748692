#pragma once
#include <cstring>
#include <tapestry/core/parallel.hpp>
#include <tapestry/nn/detail/vector_kernels.hpp>

namespace tapestry::nn {
/// [images, channels, pixels] to [images, pixels, channels].
template <std::floating_point T>
void channels_last(std::size_t images, std::size_t channels, std::size_t pixels, const T* in, T* out) {
  constexpr std::size_t tile = 64;
  const std::size_t tiles = block_count(pixels, tile);
  parallel_for(images * tiles, [&](std::size_t task) {
    const BlockRange range = block_range(task % tiles, pixels, tile);
    const std::size_t first = task / tiles * channels * pixels;
    for (std::size_t c = 0; c < channels; ++c)
      for (std::size_t p = range.begin; p < range.end; ++p)
        out[first + p * channels + c] = in[first + c * pixels + p];
  });
}

/// [images, pixels, channels] to [images, channels, pixels].
template <std::floating_point T>
void channels_first(std::size_t images, std::size_t channels, std::size_t pixels, const T* in, T* out) {
  constexpr std::size_t tile = 64;
  const std::size_t tiles = block_count(pixels, tile);
  parallel_for(images * tiles, [&](std::size_t task) {
    const BlockRange range = block_range(task % tiles, pixels, tile);
    const std::size_t first = task / tiles * channels * pixels;
    for (std::size_t c = 0; c < channels; ++c)
      for (std::size_t p = range.begin; p < range.end; ++p)
        out[first + c * pixels + p] = in[first + p * channels + c];
  });
}

/// Repeats each pixel of [images, height, width, channels] `factor` times along both axes.
template <std::floating_point T>
void upsample(std::size_t images, std::size_t height, std::size_t width, std::size_t channels,
              std::size_t factor, const T* in, T* out) {
  const std::size_t row = width * factor * channels;
  parallel_for(images * height, [&](std::size_t y) {
    const T* from = in + y * width * channels;
    T* const first = out + y * factor * row;
    for (std::size_t x = 0; x < width; ++x)
      for (std::size_t copy = 0; copy < factor; ++copy)
        std::memcpy(first + (x * factor + copy) * channels, from + x * channels, channels * sizeof(T));
    for (std::size_t copy = 1; copy < factor; ++copy) std::memcpy(first + copy * row, first, row * sizeof(T));
  });
}

/// Adds to each pixel the adjoints of its copies.
template <std::floating_point T>
void upsample_adjoint(std::size_t images, std::size_t height, std::size_t width, std::size_t channels,
                      std::size_t factor, const T* out_adjoint, T* in_adjoint) {
  const std::size_t row = width * factor * channels;
  parallel_for(images * height, [&](std::size_t y) {
    for (std::size_t r = 0; r < factor; ++r)
      for (std::size_t x = 0; x < width; ++x)
        for (std::size_t copy = 0; copy < factor; ++copy)
          kernels<T>().add(out_adjoint + (y * factor + r) * row + (x * factor + copy) * channels,
                           in_adjoint + (y * width + x) * channels, channels);
  });
}
}  // namespace tapestry::nn

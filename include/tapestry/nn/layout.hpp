#pragma once
#include <algorithm>
#include <concepts>
#include <cstddef>
#include <tapestry/core/parallel.hpp>

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

}  // namespace tapestry::nn

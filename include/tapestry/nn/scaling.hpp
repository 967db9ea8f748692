#pragma once
#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <tapestry/core/parallel.hpp>

namespace tapestry::nn {

/// What each factor multiplies: one value, all pixels of one channel, or all channels of one pixel.
enum class FactorOf { values, channels, pixels };

namespace detail {

inline constexpr std::size_t scaled_channel_block = 64;

/// Calls visit(image, range) for every block of channels of every image, in parallel.
template <class Visit>
void for_each_channel_block(std::size_t images, std::size_t channels, Visit visit) {
  const std::size_t blocks = block_count(channels, scaled_channel_block);
  parallel_for(images * blocks, [&](std::size_t task) {
    visit(task / blocks, block_range(task % blocks, channels, scaled_channel_block));
  });
}

}  // namespace detail

/// out = in · factors, all factors of an image at their places: in and out are [images, pixels, channels];
/// factors [images, pixels, channels], [images, channels] or [images, pixels] as `kind` says.
template <std::floating_point T>
void scale(FactorOf kind, std::size_t images, std::size_t pixels, std::size_t channels, const T* in,
           const T* factors, T* out) {
  parallel_for(images * pixels, [&](std::size_t p) {
    const T* const from = in + p * channels;
    T* const to = out + p * channels;
    const T* const factor = kind == FactorOf::values     ? factors + p * channels
                            : kind == FactorOf::channels ? factors + p / pixels * channels
                                                         : factors + p;
    const std::size_t step = kind == FactorOf::pixels ? 0 : 1;
    for (std::size_t c = 0; c < channels; ++c) to[c] = from[c] * factor[c * step];
  });
}

/// Adds to in_adjoint and factors_adjoint, which may be the same where both are of one extent. Sums over
/// pixels or channels are in double, in their order.
template <std::floating_point T>
void scale_adjoint(FactorOf kind, std::size_t images, std::size_t pixels, std::size_t channels, const T* in,
                   const T* factors, const T* out_adjoint, T* in_adjoint, T* factors_adjoint) {
  if (kind == FactorOf::channels) {
    detail::for_each_channel_block(images, channels, [&](std::size_t n, const BlockRange& range) {
      std::array<double, detail::scaled_channel_block> sums{};
      for (std::size_t p = n * pixels; p < (n + 1) * pixels; ++p)
        for (std::size_t c = range.begin; c < range.end; ++c) {
          const std::size_t i = p * channels + c;
          sums[c - range.begin] += static_cast<double>(out_adjoint[i]) * static_cast<double>(in[i]);
          in_adjoint[i] += out_adjoint[i] * factors[n * channels + c];
        }
      for (std::size_t c = range.begin; c < range.end; ++c)
        factors_adjoint[n * channels + c] += static_cast<T>(sums[c - range.begin]);
    });
    return;
  }
  parallel_for(images * pixels, [&](std::size_t p) {
    double sum = 0;
    for (std::size_t i = p * channels; i < (p + 1) * channels; ++i) {
      const bool is_own = kind == FactorOf::values;
      in_adjoint[i] += out_adjoint[i] * factors[is_own ? i : p];
      if (is_own)
        factors_adjoint[i] += out_adjoint[i] * in[i];
      else
        sum += static_cast<double>(out_adjoint[i]) * static_cast<double>(in[i]);
    }
    if (kind == FactorOf::pixels) factors_adjoint[p] += static_cast<T>(sum);
  });
}

}  // namespace tapestry::nn

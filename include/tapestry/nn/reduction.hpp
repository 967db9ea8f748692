#pragma once
#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>

namespace tapestry::nn {

/// Mean over the pixels of each channel: [images, pixels, channels] to [images, channels].
template <std::floating_point T>
void average_pool(std::size_t images, std::size_t pixels, std::size_t channels, const T* in, T* out) {
  for (std::size_t n = 0; n < images; ++n)
    for (std::size_t c = 0; c < channels; ++c) {
      double sum = 0;
      for (std::size_t p = 0; p < pixels; ++p)
        sum += static_cast<double>(in[(n * pixels + p) * channels + c]);
      out[n * channels + c] = static_cast<T>(sum / static_cast<double>(pixels));
    }
}

/// Adds each mean's adjoint, divided by the number of pixels, to every pixel.
template <std::floating_point T>
void average_pool_adjoint(std::size_t images, std::size_t pixels, std::size_t channels, const T* out_adjoint,
                          T* in_adjoint) {
  for (std::size_t n = 0; n < images; ++n)
    for (std::size_t p = 0; p < pixels; ++p)
      for (std::size_t c = 0; c < channels; ++c)
        in_adjoint[(n * pixels + p) * channels + c] += out_adjoint[n * channels + c] / static_cast<T>(pixels);
}

/// softmax(x / temperature) over each of `groups` equal runs of an image's values in the order
/// [channel, pixel], as Darknet counts them; in and out are [images, pixels, channels].
template <std::floating_point T>
void softmax(std::size_t images, std::size_t pixels, std::size_t channels, std::size_t groups,
             double temperature, const T* in, T* out) {
  const std::size_t size = pixels * channels / groups;
  for (std::size_t n = 0; n < images; ++n)
    for (std::size_t g = 0; g < groups; ++g) {
      const auto at = [&](std::size_t i) {
        const std::size_t position = g * size + i;  // channel · pixels + pixel
        return n * pixels * channels + position % pixels * channels + position / pixels;
      };
      double largest = static_cast<double>(in[at(0)]);
      for (std::size_t i = 1; i < size; ++i) largest = std::max(largest, static_cast<double>(in[at(i)]));
      double sum = 0;
      for (std::size_t i = 0; i < size; ++i)
        sum += std::exp((static_cast<double>(in[at(i)]) - largest) / temperature);
      for (std::size_t i = 0; i < size; ++i)
        out[at(i)] = static_cast<T>(std::exp((static_cast<double>(in[at(i)]) - largest) / temperature) / sum);
    }
}

/// Adds yᵢ·(gᵢ − Σ yⱼ·gⱼ)/temperature, with y softmax's result and g its adjoint.
template <std::floating_point T>
void softmax_adjoint(std::size_t images, std::size_t pixels, std::size_t channels, std::size_t groups,
                     double temperature, const T* out, const T* out_adjoint, T* in_adjoint) {
  const std::size_t size = pixels * channels / groups;
  for (std::size_t n = 0; n < images; ++n)
    for (std::size_t g = 0; g < groups; ++g) {
      const auto at = [&](std::size_t i) {
        const std::size_t position = g * size + i;
        return n * pixels * channels + position % pixels * channels + position / pixels;
      };
      double dot = 0;
      for (std::size_t i = 0; i < size; ++i)
        dot += static_cast<double>(out[at(i)]) * static_cast<double>(out_adjoint[at(i)]);
      for (std::size_t i = 0; i < size; ++i)
        in_adjoint[at(i)] += static_cast<T>(static_cast<double>(out[at(i)]) *
                                            (static_cast<double>(out_adjoint[at(i)]) - dot) / temperature);
    }
}

}  // namespace tapestry::nn

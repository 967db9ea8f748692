#pragma once
#include <concepts>
#include <cstddef>
#include <cstring>
#include <optional>
#include <tapestry/core/parallel.hpp>
#include <tapestry/nn/vector_kernels.hpp>
#include <tapestry/nn/window.hpp>

namespace tapestry::nn {

/// Repeats each pixel of [images, height, width, channels] `factor` times along both axes, times `scale`.
///
/// \param window  of the input: only the copies of its pixels are written. None: all
template <std::floating_point T>
void upsample(std::size_t images, std::size_t height, std::size_t width, std::size_t channels,
              std::size_t factor, T scale, const T* in, T* out, const std::optional<Window>& window = {}) {
  const Window own = window.value_or(Window{{0, height}, {0, width}});
  const std::size_t row = width * factor * channels;
  const std::size_t written = own.width() * factor * channels;
  parallel_for(images * own.height(), [&](std::size_t task) {
    const std::size_t y = task / own.height() * height + own.rows.begin + task % own.height();
    const T* from = in + (y * width + own.columns.begin) * channels;
    T* const first = out + y * factor * row + own.columns.begin * factor * channels;
    for (std::size_t x = 0; x < own.width(); ++x)
      for (std::size_t copy = 0; copy < factor; ++copy)
        std::memcpy(first + (x * factor + copy) * channels, from + x * channels, channels * sizeof(T));
    if (scale != T(1))
      for (std::size_t i = 0; i < written; ++i) first[i] *= scale;
    for (std::size_t copy = 1; copy < factor; ++copy)
      std::memcpy(first + copy * row, first, written * sizeof(T));
  });
}

/// Adds to each pixel, or to those of a window of the input, the adjoints of its copies, times `scale`.
template <std::floating_point T>
void upsample_adjoint(std::size_t images, std::size_t height, std::size_t width, std::size_t channels,
                      std::size_t factor, T scale, const T* out_adjoint, T* in_adjoint,
                      const std::optional<Window>& window = {}) {
  const Window own = window.value_or(Window{{0, height}, {0, width}});
  const std::size_t row = width * factor * channels;
  parallel_for(images * own.height(), [&](std::size_t task) {
    const std::size_t y = task / own.height() * height + own.rows.begin + task % own.height();
    for (std::size_t r = 0; r < factor; ++r)
      for (std::size_t x = own.columns.begin; x < own.columns.end; ++x)
        for (std::size_t copy = 0; copy < factor; ++copy) {
          const T* const from = out_adjoint + (y * factor + r) * row + (x * factor + copy) * channels;
          T* const to = in_adjoint + (y * width + x) * channels;
          if (scale == T(1)) {
            kernels<T>().add(from, to, channels);
          } else {
            for (std::size_t c = 0; c < channels; ++c) to[c] += scale * from[c];
          }
        }
  });
}

}  // namespace tapestry::nn

#pragma once
#include <algorithm>
#include <concepts>
#include <cstddef>
#include <tapestry/core/parallel.hpp>
#include <tapestry/nn/vector_kernels.hpp>

namespace tapestry::nn {

/// Max-pooling of pictures [row, column, channel]. The window of output (y, x) begins at
/// (y·stride − before, x·stride − before); what lies outside counts as −∞.
struct PoolingShape {
  std::size_t in_height = 1, in_width = 1;
  std::size_t out_height = 1, out_width = 1;
  std::size_t channels = 1;
  std::size_t size = 2;
  std::size_t stride = 2;
  std::size_t before = 0;

  [[nodiscard]] std::size_t in_size() const { return in_height * in_width * channels; }
  [[nodiscard]] std::size_t out_size() const { return out_height * out_width * channels; }
};

namespace detail {
struct PoolWindow {
  std::size_t begin;
  std::size_t end;
};

[[nodiscard]] inline PoolWindow pool_window(std::size_t output, const PoolingShape& shape,
                                            std::size_t extent) {
  const std::size_t shifted = output * shape.stride;
  const std::size_t begin = shifted > shape.before ? shifted - shape.before : 0;
  const std::size_t end = shifted + shape.size > shape.before ? shifted + shape.size - shape.before : 0;
  return {std::min(begin, extent), std::min(end, extent)};
}
}  // namespace detail

/// Largest value of each window, and which pixel of the picture it is; of equal ones the first in reading
/// order, and NaN counts as larger than everything, so that it stays visible.
///
/// \param in      [images, row, column, channel], readable 128 bytes past its end; each window meets it
/// \param choice  row · width + column for each output, or null if not wanted
template <std::floating_point T>
void max_pool(const PoolingShape& shape, std::size_t images, const T* in, T* out, Position<T>* choice) {
  parallel_for(images * shape.out_height, [&](std::size_t task) {
    const T* picture = in + task / shape.out_height * shape.in_size();
    const auto rows = detail::pool_window(task % shape.out_height, shape, shape.in_height);
    MaxPoolArguments<T> window{};
    window.rows = rows.end - rows.begin;
    window.row_step = shape.in_width * shape.channels;
    window.channels = shape.channels;
    window.width = shape.in_width;
    for (std::size_t x = 0; x < shape.out_width; ++x) {
      const auto columns = detail::pool_window(x, shape, shape.in_width);
      const std::size_t first = rows.begin * shape.in_width + columns.begin;
      window.columns = columns.end - columns.begin;
      window.in = picture + first * shape.channels;
      window.first_position = static_cast<Position<T>>(first);
      window.out = out + (task * shape.out_width + x) * shape.channels;
      window.choice = choice == nullptr ? nullptr : choice + (task * shape.out_width + x) * shape.channels;
      kernels<T>().max_pool_pixel(window);
    }
  });
}

/// Adds each output's adjoint to the pixel that was chosen for it.
template <std::floating_point T>
void max_pool_adjoint(const PoolingShape& shape, std::size_t images, const Position<T>* choice,
                      const T* out_adjoint, T* in_adjoint) {
  const std::size_t channels = shape.channels;
  // Pictures, and slices of channels of each, are independent of one another.
  constexpr std::size_t slice = 32;
  const std::size_t slices = block_count(channels, slice);
  parallel_for(images * slices, [&](std::size_t task) {
    const std::size_t image = task / slices;
    const BlockRange range = block_range(task % slices, channels, slice);
    const std::size_t first = image * shape.out_size();
    T* const picture = in_adjoint + image * shape.in_size();
    for (std::size_t pixel = 0; pixel < shape.out_height * shape.out_width; ++pixel)
      for (std::size_t i = range.begin; i < range.end; ++i) {
        const std::size_t output = first + pixel * channels + i;
        picture[static_cast<std::size_t>(choice[output]) * channels + i] += out_adjoint[output];
      }
  });
}

}  // namespace tapestry::nn

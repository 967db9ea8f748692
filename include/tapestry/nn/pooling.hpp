#pragma once
#include <algorithm>
#include <concepts>
#include <cstddef>
#include <optional>
#include <tapestry/core/parallel.hpp>
#include <tapestry/nn/convolution_geometry.hpp>
#include <tapestry/nn/vector_kernels.hpp>
#include <tapestry/nn/window.hpp>

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

  /// The windows as those of a convolution with as many taps.
  [[nodiscard]] AxisWindow rows() const { return axis(in_height, out_height); }
  [[nodiscard]] AxisWindow columns() const { return axis(in_width, out_width); }
  [[nodiscard]] std::size_t in_size() const { return in_height * in_width * channels; }
  [[nodiscard]] std::size_t out_size() const { return out_height * out_width * channels; }

 private:
  [[nodiscard]] AxisWindow axis(std::size_t input, std::size_t output) const {
    return {input, output, size, stride, 1, static_cast<std::ptrdiff_t>(before)};
  }
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
/// \param window  of the output: nothing else is written. None: all
template <std::floating_point T>
void max_pool(const PoolingShape& shape, std::size_t images, const T* in, T* out, Position<T>* choice,
              const std::optional<Window>& window = {}) {
  const Window own = window.value_or(Window{{0, shape.out_height}, {0, shape.out_width}});
  parallel_for(images * own.height(), [&](std::size_t task) {
    const std::size_t image = task / own.height();
    const std::size_t y = own.rows.begin + task % own.height();
    const T* picture = in + image * shape.in_size();
    const std::size_t out_row = (image * shape.out_height + y) * shape.out_width;
    const auto rows = detail::pool_window(y, shape, shape.in_height);
    MaxPoolArguments<T> place{};
    place.rows = rows.end - rows.begin;
    place.row_step = shape.in_width * shape.channels;
    place.channels = shape.channels;
    place.width = shape.in_width;
    for (std::size_t x = own.columns.begin; x < own.columns.end; ++x) {
      const auto columns = detail::pool_window(x, shape, shape.in_width);
      const std::size_t first = rows.begin * shape.in_width + columns.begin;
      place.columns = columns.end - columns.begin;
      place.in = picture + first * shape.channels;
      place.first_position = static_cast<Position<T>>(first);
      place.out = out + (out_row + x) * shape.channels;
      place.choice = choice == nullptr ? nullptr : choice + (out_row + x) * shape.channels;
      kernels<T>().max_pool_pixel(place);
    }
  });
}

/// Adds the adjoint of each output, or of those in a window, to the pixel that was chosen for it.
template <std::floating_point T>
void max_pool_adjoint(const PoolingShape& shape, std::size_t images, const Position<T>* choice,
                      const T* out_adjoint, T* in_adjoint, const std::optional<Window>& window = {}) {
  const Window own = window.value_or(Window{{0, shape.out_height}, {0, shape.out_width}});
  const std::size_t channels = shape.channels;
  // Pictures, and slices of channels of each, are independent of one another.
  constexpr std::size_t slice = 32;
  const std::size_t slices = block_count(channels, slice);
  parallel_for(images * slices, [&](std::size_t task) {
    const std::size_t image = task / slices;
    const BlockRange range = block_range(task % slices, channels, slice);
    const std::size_t first = image * shape.out_size();
    T* const picture = in_adjoint + image * shape.in_size();
    for (std::size_t y = own.rows.begin; y < own.rows.end; ++y)
      for (std::size_t x = own.columns.begin; x < own.columns.end; ++x)
        for (std::size_t i = range.begin; i < range.end; ++i) {
          const std::size_t output = first + (y * shape.out_width + x) * channels + i;
          picture[static_cast<std::size_t>(choice[output]) * channels + i] += out_adjoint[output];
        }
  });
}

}  // namespace tapestry::nn

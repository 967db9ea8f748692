#pragma once
#include <concepts>
#include <cstddef>
#include <tapestry/core/parallel.hpp>

namespace tapestry::nn {

/// What is rearranged: [height, width, channels], height and width multiples of stride, channels of stride².
struct ReorgShape {
  std::size_t height = 0, width = 0, channels = 0;
  std::size_t stride = 1;

  [[nodiscard]] std::size_t size() const { return height * width * channels; }
};

namespace detail {

/// Calls visit(from, to) for the positions, within one image, of all values that come into one row of the
/// output.
template <std::invocable<std::size_t, std::size_t> Visit>
void for_each_reorganised(const ReorgShape& in, std::size_t row, Visit visit) {
  const std::size_t s = in.stride;
  const std::size_t out_height = in.height / s, out_width = in.width / s, out_channels = in.channels * s * s;
  const std::size_t folded = in.channels / (s * s);  // C'
  for (std::size_t column = 0; column < out_width; ++column)
    for (std::size_t channel = 0; channel < out_channels; ++channel) {
      const std::size_t n = (channel * out_height + row) * out_width + column;
      const std::size_t i = n % in.width, j = n / in.width % in.height, k = n / (in.width * in.height);
      const std::size_t x = i * s + k / folded % s, y = j * s + k / folded / s;
      const std::size_t m = (k % folded * in.height * s + y) * in.width * s + x;
      const std::size_t pixel = m % (in.width * in.height);
      visit(pixel * in.channels + m / (in.width * in.height),
            (row * out_width + column) * out_channels + channel);
    }
}

}  // namespace detail

/// [images, H, W, C] to [images, H / s, W / s, s²·C] in the order of Darknet's [reorg], which is not that of
/// space to depth. With both seen channels first, as flat lists: value n of the output, taken apart as
/// n = (k·H + j)·W + i, is the input's value ((k mod C')·s·H + s·j + ⌊o/s⌋)·s·W + s·i + o mod s, where
/// C' = C / s² and o = ⌊k / C'⌋. A permutation.
/// Source: function reorg_cpu of pjreddie's Darknet, as [reorg] calls it; the weights of YOLOv2 depend on it.
template <std::floating_point T>
void reorg(const ReorgShape& shape, std::size_t images, const T* in, T* out) {
  const std::size_t rows = shape.height / shape.stride;
  parallel_for(images * rows, [&](std::size_t task) {
    const std::size_t first = task / rows * shape.size();
    detail::for_each_reorganised(
        shape, task % rows, [&](std::size_t from, std::size_t to) { out[first + to] = in[first + from]; });
  });
}

/// Adds the adjoint of each value to where the value came from.
template <std::floating_point T>
void reorg_adjoint(const ReorgShape& shape, std::size_t images, const T* out_adjoint, T* in_adjoint) {
  const std::size_t rows = shape.height / shape.stride;
  parallel_for(images * rows, [&](std::size_t task) {
    const std::size_t first = task / rows * shape.size();
    detail::for_each_reorganised(shape, task % rows, [&](std::size_t from, std::size_t to) {
      in_adjoint[first + from] += out_adjoint[first + to];
    });
  });
}

}  // namespace tapestry::nn

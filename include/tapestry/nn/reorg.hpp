#pragma once
#include <concepts>
#include <cstddef>
#include <tapestry/core/parallel.hpp>

namespace tapestry::nn {

/// Which value comes where in reorg().
enum class ReorgOrder { darknet, space_to_depth };

/// What is rearranged: [height, width, channels], height and width multiples of stride, channels in the order
/// darknet of stride².
struct ReorgShape {
  std::size_t height = 0, width = 0, channels = 0;
  std::size_t stride = 1;
  ReorgOrder order = ReorgOrder::darknet;

  [[nodiscard]] std::size_t size() const { return height * width * channels; }
};

namespace detail {

/// Where the value comes from that stands in a row, column and channel of the output, within one image.
[[nodiscard]] inline std::size_t reorganised_from(const ReorgShape& in, std::size_t row, std::size_t column,
                                                  std::size_t channel) {
  const std::size_t s = in.stride;
  if (in.order == ReorgOrder::space_to_depth) {
    const std::size_t o = channel / in.channels;
    return ((row * s + o / s) * in.width + column * s + o % s) * in.channels + channel % in.channels;
  }
  const std::size_t folded = in.channels / (s * s);  // C'
  const std::size_t n = (channel * (in.height / s) + row) * (in.width / s) + column;
  const std::size_t i = n % in.width, j = n / in.width % in.height, k = n / (in.width * in.height);
  const std::size_t x = i * s + k / folded % s, y = j * s + k / folded / s;
  const std::size_t m = (k % folded * in.height * s + y) * in.width * s + x;
  return m % (in.width * in.height) * in.channels + m / (in.width * in.height);
}

/// Calls visit(from, to) for the positions, within one image, of all values that come into one row of the
/// output.
template <std::invocable<std::size_t, std::size_t> Visit>
void for_each_reorganised(const ReorgShape& in, std::size_t row, Visit visit) {
  const std::size_t out_width = in.width / in.stride, out_channels = in.channels * in.stride * in.stride;
  for (std::size_t column = 0; column < out_width; ++column)
    for (std::size_t channel = 0; channel < out_channels; ++channel)
      visit(reorganised_from(in, row, column, channel), (row * out_width + column) * out_channels + channel);
}

}  // namespace detail

/// [images, H, W, C] to [images, H / s, W / s, s²·C], a permutation.
///
/// Space to depth puts into channel o·C + c what channel c has ⌊o/s⌋ rows down and o mod s columns to the
/// right of each block's first pixel. It is [reorg3d] of AlexeyAB's Darknet.
///
/// The order darknet is that of [reorg], and another one. With both seen channels first, as flat lists: value
/// n of the output, taken apart as n = (k·H + j)·W + i, is the input's value ((k mod C')·s·H + s·j +
/// ⌊o/s⌋)·s·W + s·i + o mod s, where C' = C / s² and o = ⌊k / C'⌋. Source: function reorg_cpu of pjreddie's
/// Darknet, as [reorg] calls it; the weights of YOLOv2 depend on it.
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

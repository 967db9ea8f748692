#pragma once
#include <algorithm>
#include <concepts>
#include <cstddef>
#include <tapestry/core/parallel.hpp>
#include <tapestry/nn/convolution_geometry.hpp>
#include <tapestry/nn/packed_convolution.hpp>
#include <tapestry/nn/window.hpp>

namespace tapestry::nn {

/// Outputs of an axis that depend on any of a range of inputs, where `tile` outputs side by side are computed
/// from all inputs that they read together: whole tiles, at least one, from 0 to axis.output.
[[nodiscard]] inline BlockRange outputs_reached(const AxisWindow& axis, std::size_t tile, BlockRange inputs) {
  // Tile k reads from k·tile·stride − padding on, `reach` inputs.
  const auto step = static_cast<std::ptrdiff_t>(tile * axis.stride);
  const auto reach = static_cast<std::ptrdiff_t>(axis.reach(tile));
  const auto last_tile = static_cast<std::ptrdiff_t>(block_count(axis.output, tile)) - 1;
  const auto most = static_cast<std::ptrdiff_t>(inputs.end) - 1 + axis.padding;  // of k · step
  const auto least = static_cast<std::ptrdiff_t>(inputs.begin) + axis.padding - reach + 1;
  const auto last = std::clamp(most < 0 ? 0 : most / step, std::ptrdiff_t(0), last_tile);
  const auto first = std::clamp(least <= 0 ? 0 : (least + step - 1) / step, std::ptrdiff_t(0), last);
  return {static_cast<std::size_t>(first) * tile,
          std::min(axis.output, (static_cast<std::size_t>(last) + 1) * tile)};
}

/// Inputs of an axis between the first and the last that whole tiles of a range of outputs read; empty where
/// all of them lie outside.
[[nodiscard]] inline BlockRange inputs_read(const AxisWindow& axis, std::size_t tile, BlockRange outputs) {
  if (outputs.begin >= outputs.end) return {0, 0};
  const std::size_t first = outputs.begin / tile * tile;
  const std::size_t count = block_count(outputs.end, tile) * tile - first;
  const auto begin = static_cast<std::ptrdiff_t>(first * axis.stride) - axis.padding;
  const auto end = begin + static_cast<std::ptrdiff_t>(axis.reach(count));
  const auto extent = static_cast<std::ptrdiff_t>(axis.input);
  return {static_cast<std::size_t>(std::clamp(begin, std::ptrdiff_t(0), extent)),
          static_cast<std::size_t>(std::clamp(end, std::ptrdiff_t(0), extent))};
}

/// Outputs of an axis that lie in a range of places, where output i is at place first + i · step.
[[nodiscard]] constexpr BlockRange outputs_inside(std::size_t first, std::size_t step, std::size_t count,
                                                  BlockRange places) {
  const auto before = [&](std::size_t place) {
    return std::min(count, place > first ? block_count(place - first, step) : 0);
  };
  return {before(places.begin), before(places.end)};
}

/// Where the outputs of a packed convolution lie within a window of the picture that they are written to.
template <std::floating_point T>
[[nodiscard]] Window outputs_inside(const PackedConvolution<T>& packed, const Window& window) {
  const ConvolutionShape& s = packed.shape;
  return {outputs_inside(packed.first_row, packed.row_step, s.rows.output, window.rows),
          outputs_inside(packed.first_column, packed.column_step, s.columns.output, window.columns)};
}

/// The convolution that writes only those outputs that lie within a window of the picture that they are
/// written to; possibly none. Sums are the same bits if the window's outputs begin and end with whole tiles
/// of tile_of().
template <std::floating_point T>
[[nodiscard]] PackedConvolution<T> windowed(const PackedConvolution<T>& packed, const Window& window) {
  PackedConvolution<T> part = packed;
  const auto crop = [](AxisWindow& axis, std::size_t& first, std::size_t step, BlockRange outputs) {
    axis.padding -= static_cast<std::ptrdiff_t>(outputs.begin * axis.stride);
    axis.output = outputs.end - outputs.begin;
    first += outputs.begin * step;
  };
  const Window outputs = outputs_inside(packed, window);
  crop(part.shape.rows, part.first_row, part.row_step, outputs.rows);
  crop(part.shape.columns, part.first_column, part.column_step, outputs.columns);
  return part;
}

}  // namespace tapestry::nn

#pragma once
#include <tapestry/nn/detail/packed_convolution.hpp>

namespace tapestry::nn {
/// Neighbouring outputs of an axis that are computed together from all their inputs. The rounding of each
/// output therefore depends on most of these inputs.
struct OutputTile {
  std::size_t outputs = 1;
  std::size_t own_of_first = 0;  ///< leading inputs that affect the first output only
  std::size_t own_of_last = 0;   ///< trailing inputs that affect the last output only
};

/// Outputs of an axis whose bits may depend on a range of inputs; at least one output.
[[nodiscard]] inline BlockRange outputs_reached(const AxisWindow& axis, const OutputTile& tile,
                                                BlockRange inputs) {
  // Tile k reads from k·step − padding on, `reach` inputs.
  const auto step = static_cast<std::ptrdiff_t>(tile.outputs * axis.stride);
  const auto reach = static_cast<std::ptrdiff_t>(axis.reach(tile.outputs));
  const auto last_tile = static_cast<std::ptrdiff_t>(block_count(axis.output, tile.outputs)) - 1;
  const auto first_place = static_cast<std::ptrdiff_t>(inputs.begin) + axis.padding;
  const auto last_place = static_cast<std::ptrdiff_t>(inputs.end) - 1 + axis.padding;
  const auto least = first_place - reach + 1;  // smallest k · step
  const auto last = std::clamp(last_place < 0 ? 0 : last_place / step, std::ptrdiff_t(0), last_tile);
  const auto first = std::clamp(least <= 0 ? 0 : (least + step - 1) / step, std::ptrdiff_t(0), last);
  const bool only_last = first_place - first * step >= reach - static_cast<std::ptrdiff_t>(tile.own_of_last);
  const bool only_first = last_place - last * step < static_cast<std::ptrdiff_t>(tile.own_of_first);
  const std::size_t begin =
      static_cast<std::size_t>(first) * tile.outputs + (only_last ? tile.outputs - 1 : 0);
  const std::size_t end = static_cast<std::size_t>(last) * tile.outputs + (only_first ? 1 : tile.outputs);
  return {std::min(begin, axis.output - 1),
          std::clamp(end, std::min(begin, axis.output - 1) + 1, axis.output)};
}

/// Range of inputs of an axis that the bits of a range of outputs depend on. Empty
/// where all of them lie outside.
[[nodiscard]] inline BlockRange inputs_needed(const AxisWindow& axis, const OutputTile& tile,
                                              BlockRange outputs) {
  if (outputs.begin >= outputs.end) return {0, 0};
  const std::size_t first = outputs.begin / tile.outputs * tile.outputs;
  const std::size_t end = block_count(outputs.end, tile.outputs) * tile.outputs;
  const std::size_t before = outputs.begin == first ? 0 : tile.own_of_first;
  const std::size_t after = outputs.end == end ? 0 : tile.own_of_last;
  const auto begin_place = static_cast<std::ptrdiff_t>(first * axis.stride) - axis.padding;
  const auto end_place = begin_place + static_cast<std::ptrdiff_t>(axis.reach(end - first) - after);
  const auto inside = [&](std::ptrdiff_t place) {
    return static_cast<std::size_t>(
        std::clamp(place, std::ptrdiff_t(0), static_cast<std::ptrdiff_t>(axis.input)));
  };
  return {inside(begin_place + static_cast<std::ptrdiff_t>(before)), inside(end_place)};
}

/// Outputs of an axis that lie in a range of places, where output i is at place first + i · step.
[[nodiscard]] constexpr BlockRange outputs_inside(std::size_t first, std::size_t step, std::size_t count,
                                                  BlockRange places) {
  const auto before = [&](std::size_t place) {
    return std::min(count, place > first ? block_count(place - first, step) : 0);
  };
  return {before(places.begin), before(places.end)};
}

/// Outputs of a packed convolution that lie within a window of the picture they are written to.
template <std::floating_point T>
[[nodiscard]] MapWindow outputs_inside(const PackedConvolution<T>& packed, const MapWindow& window) {
  const ConvolutionShape& s = packed.shape;
  return {outputs_inside(packed.first_row, packed.row_step, s.rows.output, window.rows),
          outputs_inside(packed.first_column, packed.column_step, s.columns.output, window.columns)};
}

/// Restricts the convolution to outputs within a window of the picture they are written to, and to those that
/// share a tile with them; possibly none. They have the bits of the whole convolution.
///
/// \param tile  along both axes, see tile_of()
template <std::floating_point T>
[[nodiscard]] PackedConvolution<T> windowed(const PackedConvolution<T>& packed, const OutputTile& tile,
                                            const MapWindow& window) {
  PackedConvolution<T> part = packed;
  const auto crop = [](AxisWindow& axis, std::size_t& first, std::size_t step, BlockRange outputs) {
    axis.padding -= static_cast<std::ptrdiff_t>(outputs.begin * axis.stride);
    axis.output = outputs.end - outputs.begin;
    first += outputs.begin * step;
  };
  MapWindow outputs = outputs_inside(packed, window);
  outputs.rows = aligned(outputs.rows, tile.outputs, packed.shape.rows.output);
  outputs.columns = aligned(outputs.columns, tile.outputs, packed.shape.columns.output);
  if (outputs_inside(packed, window).is_empty()) outputs = {};
  crop(part.shape.rows, part.first_row, part.row_step, outputs.rows);
  crop(part.shape.columns, part.first_column, part.column_step, outputs.columns);
  return part;
}
}  // namespace tapestry::nn

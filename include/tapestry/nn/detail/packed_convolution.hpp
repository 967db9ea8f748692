#pragma once
#include <tapestry/nn/detail/convolution_region.hpp>
#include <tapestry/nn/detail/vector_kernels.hpp>

namespace tapestry::nn {
/// One convolution with its weights laid out for the kernels. It writes every row_step-th row and
/// column_step-th column of a picture with out_columns columns, so that it can be a part of an adjoint.
///
/// Weights of each group are cut into panels of two vectors of output channels (one at the end, if that is
/// enough), each [row tap, column tap, input channel, lane]; missing lanes are zero. Depthwise weights are
/// [row tap, column tap, channel], channels rounded up to whole vectors. Copies share them.
template <std::floating_point T>
struct PackedConvolution {
  ConvolutionShape shape{};
  std::size_t out_columns = 0;
  std::size_t first_row = 0, row_step = 1;
  std::size_t first_column = 0, column_step = 1;
  /// Whether sums read a copy of the inputs, with zeros around the picture. Decided for the whole picture, as
  /// the order of a sum depends on it.
  bool copies_inputs = true;
  /// Inputs and weights are words that hold pairs of channels, as paired() makes them.
  bool holds_pairs = false;
  std::shared_ptr<Buffer<T>> weights = std::make_shared<Buffer<T>>();
  /// The weights transformed by Winograd's algorithm, made by its first pass and kept where they are few; by
  /// form, first of values, then of pairs. Null for single taps, which are also packed in every pass.
  struct Transformed {
    std::once_flag made;
    Buffer<T> filters;
  };
  std::shared_ptr<std::array<Transformed, 2 * winograd_form_count>> transformed{};

  [[nodiscard]] std::size_t reduction() const { return shape.taps() * shape.group_in(); }
};

[[nodiscard]] constexpr std::size_t round_up(std::size_t count, std::size_t multiple) {
  return (count + multiple - 1) / multiple * multiple;
}

/// Lanes of the panel that begins at output channel `first` of `count`.
[[nodiscard]] constexpr std::size_t panel_lanes(std::size_t first, std::size_t count, std::size_t lanes) {
  return count - first > lanes ? 2 * lanes : lanes;
}

namespace detail {
/// Number of tasks that pays for so many operations. A task of fewer than about half a million operations
/// costs more than it gains.
[[nodiscard]] inline std::size_t useful_tasks(double operations) {
  return static_cast<std::size_t>(std::clamp(operations / 5e5, 1.0, 16.0));
}

/// Fills `packed.weights`, and how inputs are read, from weight(group, output channel, input channel, row
/// tap, column tap), with channels counted within the group.
template <std::floating_point T, class Weight>
void pack_weights(PackedConvolution<T>& packed, Weight weight) {
  const std::size_t lanes = kernels<T>().lanes;
  const ConvolutionShape& shape = packed.shape;
  packed.copies_inputs = !reads_only_inside(shape);
  if (shape.is_depthwise()) {
    const std::size_t pitch = round_up(shape.groups, lanes);
    packed.weights->resize(shape.taps() * pitch);
    packed.weights->fill_zero();
    for (std::size_t y = 0; y < shape.rows.taps; ++y)
      for (std::size_t x = 0; x < shape.columns.taps; ++x)
        for (std::size_t g = 0; g < shape.groups; ++g)
          packed.weights->data()[(y * shape.columns.taps + x) * pitch + g] = weight(g, 0, 0, y, x);
    return;
  }
  if (shape.taps() > 1)
    packed.transformed = std::make_shared<typename decltype(packed.transformed)::element_type>();
  const std::size_t padded = round_up(shape.group_out(), lanes);
  packed.weights->resize(shape.groups * padded * packed.reduction());
  const std::size_t panels = block_count(padded, 2 * lanes);
  parallel_for(shape.groups * panels, [&](std::size_t task) {
    const std::size_t g = task / panels;
    const std::size_t first = task % panels * 2 * lanes;
    const std::size_t width = panel_lanes(first, padded, lanes);
    T* const panel = packed.weights->data() + (g * padded + first) * packed.reduction();
    const std::size_t there = std::min(width, shape.group_out() - first);
    constexpr std::size_t at_once = 16;  // input channels, whose weights then stay in the first cache
    for (std::size_t begin = 0; begin < shape.group_in(); begin += at_once)
      for (std::size_t tap = 0; tap < shape.taps(); ++tap) {
        const std::size_t y = tap / shape.columns.taps, x = tap % shape.columns.taps;
        T* to = panel + (tap * shape.group_in() + begin) * width;
        for (std::size_t i = begin; i < std::min(begin + at_once, shape.group_in()); ++i, to += width) {
          for (std::size_t lane = 0; lane < there; ++lane) to[lane] = weight(g, first + lane, i, y, x);
          std::fill(to + there, to + width, T(0));
        }
      }
  });
}
}  // namespace detail

/// The convolution itself. Weights are [output channel, input channel of its group, row tap, column tap];
/// they are read through `weight(index)`, which may scale them.
template <std::floating_point T, class WeightAt>
[[nodiscard]] PackedConvolution<T> pack_convolution(const ConvolutionShape& shape, WeightAt weight_at) {
  PackedConvolution<T> packed{shape, shape.columns.output};
  detail::pack_weights(
      packed, [&](std::size_t g, std::size_t o, std::size_t i, std::size_t y, std::size_t x) {
        const std::size_t filter = g * shape.group_out() + o;
        return static_cast<T>(
            weight_at(((filter * shape.group_in() + i) * shape.rows.taps + y) * shape.columns.taps + x));
      });
  return packed;
}

/// The adjoint of the same convolution: one convolution for each class of input pixels modulo the stride.
/// Together they write each input pixel that any output reads.
template <std::floating_point T, class WeightAt>
[[nodiscard]] std::vector<PackedConvolution<T>> pack_convolution_adjoint(const ConvolutionShape& shape,
                                                                         WeightAt weight_at) {
  std::vector<PackedConvolution<T>> parts;
  const auto column_parts = adjoint_of(shape.columns);
  for (const AxisAdjoint& row : adjoint_of(shape.rows))
    for (const AxisAdjoint& column : column_parts) {
      PackedConvolution<T> part;
      part.shape = {row.window, column.window, shape.out_channels, shape.in_channels, shape.groups};
      part.out_columns = shape.columns.input;
      part.first_row = row.first;
      part.row_step = shape.rows.stride;
      part.first_column = column.first;
      part.column_step = shape.columns.stride;
      detail::pack_weights(
          part, [&](std::size_t g, std::size_t o, std::size_t i, std::size_t y, std::size_t x) {
            const std::size_t filter = g * shape.group_out() + i;
            const std::size_t forward_y = row.first_tap - y * row.tap_step;
            const std::size_t forward_x = column.first_tap - x * column.tap_step;
            return static_cast<T>(weight_at(((filter * shape.group_in() + o) * shape.rows.taps + forward_y) *
                                                shape.columns.taps +
                                            forward_x));
          });
      parts.push_back(std::move(part));
    }
  return parts;
}

/// True if the parts of an adjoint write every input pixel, so that it need not be zeroed before.
[[nodiscard]] inline bool adjoint_covers_input(const ConvolutionShape& shape) {
  const auto covers = [](const AxisWindow& axis) {
    return adjoint_of(axis).size() == std::min(axis.stride, axis.input);
  };
  return covers(shape.rows) && covers(shape.columns);
}
}  // namespace tapestry::nn

#pragma once
#include <tapestry/nn/detail/network/operators.hpp>

namespace tapestry::nn {
/// The attributes of a window that slides over a picture, for rows and columns; convolutions and poolings
/// share them. Source: onnx.ai, Operators.md, Conv and MaxPool.
struct KernelAttributes {
  enum class AutoPad { notset, same_upper, same_lower, valid };
  using Pair = std::array<std::size_t, 2>;

  Pair taps{1, 1};
  Pair strides{1, 1};
  Pair dilations{1, 1};
  Pair before{0, 0};  ///< zeros at the top and left
  Pair after{0, 0};   ///< zeros at the bottom and right
  AutoPad auto_pad = AutoPad::notset;

  /// Inputs from the first tap to the last.
  [[nodiscard]] std::size_t reach(std::size_t axis) const { return (taps[axis] - 1) * dilations[axis] + 1; }
};

/// \throws DomainError unless operand 0 is a batch of pictures, stored [N, H, W, C], none of them empty
[[nodiscard]] inline const Shape& picture_shape(const OperatorContext& context) {
  const Shape& shape = context.input(0).shape;
  if (!context.channels_last())
    throw DomainError({"input 0 is ", shape, "; only pictures, [N, C, H, W], are supported"});
  if (size_of(shape) == 0) throw ShapeError("input 0 is empty");
  return shape;
}

/// Settings of a window beyond this are rejected.
inline constexpr std::int64_t largest_window = std::int64_t(1) << 20U;

/// Ranges of the attributes of a window, and of further ones.
[[nodiscard]] inline std::vector<AttributeRange> window_ranges(std::vector<AttributeRange> others = {}) {
  for (const char* const name : {"kernel_shape", "strides", "dilations"})
    others.push_back({name, 1, largest_window});
  others.push_back({"pads", 0, largest_window});
  return others;
}

namespace detail {
/// Reads a list of extents whose range the operator's table states.
inline void read_extents(OperatorContext& context, const char* name, std::size_t count, std::size_t* to) {
  const auto values = context.integers(name);
  if (values.empty()) return;
  if (values.size() != count)
    throw DomainError({"attribute ", in_quotes(name), " has ", values.size(), " values, expected ", count});
  for (std::size_t i = 0; i < count; ++i) to[i] = static_cast<std::size_t>(values[i]);
}

[[nodiscard]] inline KernelAttributes::AutoPad read_auto_pad(OperatorContext& context) {
  using AutoPad = KernelAttributes::AutoPad;
  const std::string name = context.text("auto_pad", "NOTSET");
  if (name == "NOTSET" || name.empty()) return AutoPad::notset;
  if (name == "SAME_UPPER") return AutoPad::same_upper;
  if (name == "SAME_LOWER") return AutoPad::same_lower;
  if (name == "VALID") return AutoPad::valid;
  throw DomainError({"attribute 'auto_pad' is ", in_quotes(name)});
}
}  // namespace detail

/// \param taps of the weights; {0, 0}: kernel_shape is required
[[nodiscard]] inline KernelAttributes window_attributes(OperatorContext& context,
                                                        KernelAttributes::Pair taps = {0, 0}) {
  KernelAttributes window;
  window.taps = taps;
  detail::read_extents(context, "kernel_shape", 2, window.taps.data());
  if (taps[0] != 0 && window.taps != taps)
    throw DomainError({"attribute 'kernel_shape' is ", window.taps, ", but the weights have ", taps});
  if (window.taps[0] == 0 || window.taps[1] == 0) throw DomainError("there is no 'kernel_shape'");
  detail::read_extents(context, "strides", 2, window.strides.data());
  detail::read_extents(context, "dilations", 2, window.dilations.data());
  std::array<std::size_t, 4> pads{};
  detail::read_extents(context, "pads", 4, pads.data());
  window.auto_pad = detail::read_auto_pad(context);
  if (window.auto_pad != KernelAttributes::AutoPad::notset) return window;
  window.before = {pads[0], pads[1]};
  window.after = {pads[2], pads[3]};
  return window;
}

/// Sets the zeros that give an axis of `input` values ⌈input / stride⌉ outputs; returns their number.
inline std::size_t pad_same(KernelAttributes& window, std::size_t axis, std::size_t input) {
  const std::size_t stride = window.strides[axis];
  const std::size_t output = (input + stride - 1) / stride;
  const std::size_t needed = (output - 1) * stride + window.reach(axis);
  const std::size_t zeros = needed > input ? needed - input : 0;
  const bool is_upper = window.auto_pad == KernelAttributes::AutoPad::same_upper;
  window.before[axis] = is_upper ? zeros / 2 : zeros - zeros / 2;
  window.after[axis] = zeros - window.before[axis];
  return output;
}

/// The window along one axis of `input` values.
/// \param rounds_up  a last window that reaches beyond the zeros counts if it begins inside or before them
/// \throws ShapeError if there is no room for a single window
[[nodiscard]] inline AxisWindow axis_window(KernelAttributes& window, std::size_t axis, std::size_t input,
                                            bool rounds_up = false) {
  using AutoPad = KernelAttributes::AutoPad;
  const std::size_t stride = window.strides[axis];
  std::size_t output = 0;
  if (window.auto_pad == AutoPad::same_upper || window.auto_pad == AutoPad::same_lower) {
    output = pad_same(window, axis, input);
  } else {
    const std::size_t padded = input + window.before[axis] + window.after[axis];
    if (padded < window.reach(axis))
      throw ShapeError({"a window of ", window.reach(axis), " does not fit into ", padded,
                        (axis == 0 ? " rows" : " columns")});
    const std::size_t room = padded - window.reach(axis);
    output = (rounds_up ? (room + stride - 1) / stride : room / stride) + 1;
    if (rounds_up && (output - 1) * stride >= input + window.before[axis]) --output;
  }
  return {input,
          output,
          window.taps[axis],
          stride,
          window.dilations[axis],
          static_cast<std::ptrdiff_t>(window.before[axis])};
}

/// Taps of one output along one axis that lie in the picture, and their number with padding.
struct KernelTaps {
  std::size_t first = 0;  ///< input of the first of them
  std::size_t count = 0;
  std::size_t with_padding = 0;  ///< taps in the picture or the zeros around it
};

/// A pooling of pictures [images, row, column, channel], each channel alone.
struct PoolingPlan {
  AxisWindow rows{};
  AxisWindow columns{};
  std::vector<KernelTaps> row_windows{};  ///< of each output
  std::vector<KernelTaps> column_windows{};
  std::size_t images = 1;
  std::size_t channels = 1;

  [[nodiscard]] Shape out_shape() const { return {images, rows.output, columns.output, channels}; }
  [[nodiscard]] std::size_t in_size() const { return rows.input * columns.input * channels; }
  [[nodiscard]] std::size_t out_size() const { return rows.output * columns.output * channels; }
  [[nodiscard]] std::size_t row_size() const { return columns.input * channels; }

  /// Calls body(first input, output, row window, column window) for each pixel out, rows side by side.
  template <class Body>
  void for_each_output(Body body) const {
    parallel_for(images * rows.output, [&](std::size_t task) { for_each_output_of_row(task, body); });
  }

  /// Calls body(input) for each tap of a window that lies in the picture.
  template <class Body>
  void for_each_tap(std::size_t first, const KernelTaps& row, const KernelTaps& column, Body body) const {
    for (std::size_t y = 0; y < row.count; ++y)
      for (std::size_t x = 0; x < column.count; ++x)
        body(first + y * rows.spacing * row_size() + x * columns.spacing * channels);
  }

  /// The same, for bodies where several outputs may write one input: images side by side, the outputs of each
  /// in reading order.
  template <class Body>
  void for_each_output_in_order(Body body) const {
    parallel_for(images, [&](std::size_t image) {
      for (std::size_t y = 0; y < rows.output; ++y) for_each_output_of_row(image * rows.output + y, body);
    });
  }

 private:
  template <class Body>
  void for_each_output_of_row(std::size_t index, const Body& body) const {
    const KernelTaps& row = row_windows[index % rows.output];
    const std::size_t picture = index / rows.output * in_size() + row.first * row_size();
    for (std::size_t x = 0; x < columns.output; ++x)
      body(picture + column_windows[x].first * channels, (index * columns.output + x) * channels, row,
           column_windows[x]);
  }
};

/// \param may_be_empty  windows that lie outside the picture altogether have a value
/// \throws ShapeError if there are others
[[nodiscard]] inline PoolingPlan plan_pooling(OperatorContext& context, bool may_be_empty) {
  const Shape& picture = picture_shape(context);
  KernelAttributes window = window_attributes(context);
  const bool rounds_up = context.flag("ceil_mode", 0);
  PoolingPlan plan;
  plan.images = picture[0];
  plan.channels = picture[3];
  plan.rows = axis_window(window, 0, picture[1], rounds_up);
  plan.columns = axis_window(window, 1, picture[2], rounds_up);
  const auto windows = [&](const AxisWindow& axis, std::size_t after) {
    std::vector<KernelTaps> all;
    if (axis.output > static_cast<std::size_t>(2 * largest_window))
      throw ShapeError({axis.output, " windows along an axis are too many"});
    for (std::size_t i = 0; i < axis.output; ++i) {
      const BlockRange taps = detail::inner_taps(axis, i);
      if (taps.begin == taps.end && !may_be_empty)
        throw ShapeError("a window lies outside the picture altogether");
      const auto padding = static_cast<std::size_t>(axis.padding);
      const std::size_t end = axis.input + padding + after;  // counted from the first zero
      const std::size_t first = i * axis.stride;
      KernelTaps one{first + taps.begin * axis.spacing - padding, taps.end - taps.begin, 0};
      if (first < end) one.with_padding = std::min(axis.taps, (end - first - 1) / axis.spacing + 1);
      if (one.count == 0) one.first = 0;
      all.push_back(one);
    }
    return all;
  };
  plan.row_windows = windows(plan.rows, window.after[0]);
  plan.column_windows = windows(plan.columns, window.after[1]);
  return plan;
}
}  // namespace tapestry::nn

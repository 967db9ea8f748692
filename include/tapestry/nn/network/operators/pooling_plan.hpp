#pragma once
#include <algorithm>
#include <cstddef>
#include <string>
#include <tapestry/core/check.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/nn/convolution_geometry.hpp>
#include <tapestry/nn/depthwise_convolution.hpp>
#include <tapestry/nn/network/operators/window_attributes.hpp>
#include <vector>

namespace tapestry::nn {

/// Taps of one output along one axis that lie in the picture, and what the window counts.
struct WindowTaps {
  std::size_t first = 0;  ///< input of the first of them
  std::size_t count = 0;
  std::size_t with_padding = 0;  ///< taps in the picture or the zeros around it
};

/// A pooling of pictures [images, row, column, channel], each channel on its own.
struct PoolingPlan {
  AxisWindow rows{};
  AxisWindow columns{};
  std::vector<WindowTaps> row_windows{};  ///< of each output
  std::vector<WindowTaps> column_windows{};
  std::size_t images = 1;
  std::size_t channels = 1;

  [[nodiscard]] Shape out_shape() const { return {images, rows.output, columns.output, channels}; }
  [[nodiscard]] std::size_t in_size() const { return rows.input * columns.input * channels; }
  [[nodiscard]] std::size_t out_size() const { return rows.output * columns.output * channels; }
  [[nodiscard]] std::size_t row_size() const { return columns.input * channels; }

  /// Calls body(first input, output, row window, column window) for each pixel out, rows side by side.
  template <class Body>
  void for_each_output(Body body) const {
    parallel_for(images * rows.output, [&](std::size_t task) {
      const WindowTaps& row = row_windows[task % rows.output];
      const std::size_t picture = task / rows.output * in_size() + row.first * row_size();
      for (std::size_t x = 0; x < columns.output; ++x)
        body(picture + column_windows[x].first * channels, (task * columns.output + x) * channels, row,
             column_windows[x]);
    });
  }

  /// Calls body(input) for each tap of a window that lies in the picture.
  template <class Body>
  void for_each_tap(std::size_t first, const WindowTaps& row, const WindowTaps& column, Body body) const {
    for (std::size_t y = 0; y < row.count; ++y)
      for (std::size_t x = 0; x < column.count; ++x)
        body(first + y * rows.spacing * row_size() + x * columns.spacing * channels);
  }

  /// Calls the same where several outputs may reach one
  /// input: images side by side, each in reading order.
  template <class Body>
  void for_each_output_in_order(Body body) const {
    parallel_for(images, [&](std::size_t image) {
      for (std::size_t y = 0; y < rows.output; ++y)
        for (std::size_t x = 0; x < columns.output; ++x) {
          const std::size_t first =
              image * in_size() + row_windows[y].first * row_size() + column_windows[x].first * channels;
          body(first, ((image * rows.output + y) * columns.output + x) * channels, row_windows[y],
               column_windows[x]);
        }
    });
  }
};

/// \param may_be_empty  windows that lie outside the picture altogether have a value
/// \throws ShapeError if there are others
[[nodiscard]] inline PoolingPlan plan_pooling(OperatorContext& context, bool may_be_empty) {
  const Shape& picture = picture_shape(context);
  WindowAttributes window = window_attributes(context);
  const bool rounds_up = context.integer("ceil_mode", 0) != 0;
  PoolingPlan plan;
  plan.images = picture[0];
  plan.channels = picture[3];
  plan.rows = axis_window(window, 0, picture[1], rounds_up);
  plan.columns = axis_window(window, 1, picture[2], rounds_up);
  const auto windows = [&](const AxisWindow& axis, std::size_t after) {
    std::vector<WindowTaps> all;
    if (axis.output > static_cast<std::size_t>(2 * detail::largest_window))
      throw ShapeError(std::to_string(axis.output) + " windows along an axis are too many");
    for (std::size_t i = 0; i < axis.output; ++i) {
      const BlockRange taps = detail::inner_taps(axis, i);
      if (taps.begin == taps.end && !may_be_empty)
        throw ShapeError("a window lies outside the picture altogether");
      const auto padding = static_cast<std::size_t>(axis.padding);
      const std::size_t end = axis.input + padding + after;  // counted from the first zero
      const std::size_t first = i * axis.stride;
      WindowTaps one{first + taps.begin * axis.spacing - padding, taps.end - taps.begin, 0};
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

#pragma once
#include <algorithm>
#include <cstddef>
#include <numeric>
#include <vector>

namespace tapestry::nn {

/// How an axis of a convolution maps outputs to inputs: output j reads input j·stride − padding + t·spacing
/// for tap t = 0 … taps − 1, and zero where that lies outside 0 … input − 1.
struct AxisWindow {
  std::size_t input = 1;
  std::size_t output = 1;
  std::size_t taps = 1;
  std::size_t stride = 1;
  std::size_t spacing = 1;
  std::ptrdiff_t padding = 0;  ///< may be negative: the first input read then lies inside

  /// Inputs between the first and the last that `outputs` neighbouring outputs read.
  [[nodiscard]] std::size_t reach(std::size_t outputs) const {
    return (outputs - 1) * stride + (taps - 1) * spacing + 1;
  }
};

/// The part of an axis' adjoint that belongs to every stride-th input, beginning at `first`. It is again
/// a window, over outputs, whose tap t carries the forward tap first_tap − t·tap_step.
struct AxisAdjoint {
  std::size_t first = 0;
  std::size_t first_tap = 0;
  std::size_t tap_step = 1;
  AxisWindow window{};
};

/// Input i is read by output j at tap t where i + padding = j·stride + t·spacing. For inputs i ≡ first
/// (mod stride) the taps that solve this repeat with period stride / gcd(stride, spacing).
[[nodiscard]] inline std::vector<AxisAdjoint> adjoint_of(const AxisWindow& axis) {
  const std::size_t common = std::gcd(axis.stride, axis.spacing);
  const auto stride = static_cast<std::ptrdiff_t>(axis.stride);
  std::vector<AxisAdjoint> parts;
  std::vector<std::size_t> taps(std::min(axis.stride, axis.input), 0), last_tap(taps.size(), 0);
  for (std::size_t t = 0; t < axis.taps; ++t) {
    const auto place = (static_cast<std::ptrdiff_t>(t * axis.spacing) - axis.padding) % stride;
    const auto first = static_cast<std::size_t>(place < 0 ? place + stride : place);
    if (first >= taps.size()) continue;
    ++taps[first];
    last_tap[first] = t;
  }
  for (std::size_t first = 0; first < taps.size(); ++first) {
    if (taps[first] == 0) continue;
    AxisAdjoint part;
    part.first = first;
    part.first_tap = last_tap[first];
    part.tap_step = axis.stride / common;
    part.window.input = axis.output;
    part.window.output = (axis.input - first + axis.stride - 1) / axis.stride;
    part.window.taps = taps[first];
    part.window.spacing = axis.spacing / common;
    part.window.padding = -(static_cast<std::ptrdiff_t>(first) + axis.padding -
                            static_cast<std::ptrdiff_t>(part.first_tap * axis.spacing)) /
                          stride;
    parts.push_back(part);
  }
  return parts;
}

/// A convolution over activations stored as [row, column, channel].
struct ConvolutionShape {
  AxisWindow rows{};
  AxisWindow columns{};
  std::size_t in_channels = 1;   ///< of all groups together
  std::size_t out_channels = 1;  ///< of all groups together
  std::size_t groups = 1;

  [[nodiscard]] bool is_depthwise() const {
    return groups > 1 && groups == in_channels && groups == out_channels;
  }
  [[nodiscard]] std::size_t group_in() const { return in_channels / groups; }
  [[nodiscard]] std::size_t group_out() const { return out_channels / groups; }
  [[nodiscard]] std::size_t taps() const { return rows.taps * columns.taps; }
  [[nodiscard]] std::size_t in_size() const { return rows.input * columns.input * in_channels; }
  [[nodiscard]] std::size_t out_size() const { return rows.output * columns.output * out_channels; }
  [[nodiscard]] std::size_t weight_count() const { return out_channels * group_in() * taps(); }
};

/// Square filter of `size` taps with the same stride, dilation and zero padding on both axes.
[[nodiscard]] inline ConvolutionShape square_convolution(std::size_t height, std::size_t width,
                                                         std::size_t in_channels, std::size_t out_channels,
                                                         std::size_t size, std::size_t stride,
                                                         std::size_t padding, std::size_t dilation = 1,
                                                         std::size_t groups = 1) {
  const auto axis = [&](std::size_t input) {
    const std::size_t output = (input + 2 * padding - ((size - 1) * dilation + 1)) / stride + 1;
    return AxisWindow{input, output, size, stride, dilation, static_cast<std::ptrdiff_t>(padding)};
  };
  return {axis(height), axis(width), in_channels, out_channels, groups};
}

}  // namespace tapestry::nn

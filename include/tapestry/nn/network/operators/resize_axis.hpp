#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tapestry/core/check.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <vector>

namespace tapestry::nn {

/// How a resized tensor is read off: the attributes of Resize that hold for every axis.
/// Source: onnx.ai, Operators.md, Resize.
struct ResizeRule {
  std::string coordinates = "half_pixel";  ///< coordinate_transformation_mode
  std::string mode = "nearest";
  std::string nearest = "round_prefer_floor";  ///< or "simple": up before the 11th opset, down otherwise
  double cubic_a = -0.75;
  bool excludes_outside = false;
};

/// One axis that is resized.
struct ResizeAxis {
  std::size_t axis = 0;  ///< as stored
  std::size_t input = 1, output = 1;
  double scale = 1;
  double start = 0, end = 1;  ///< of tf_crop_and_resize, as parts of the axis
};

/// Output i is Σ weight[i · taps + t] · input[index[i · taps + t]] over t < taps.
struct ResizeTable {
  std::size_t axis = 0, input = 1, output = 1, taps = 1;
  std::vector<std::size_t> index{};
  std::vector<double> weight{};
  std::vector<bool> is_outside{};  ///< of each output, which then has no weights

  [[nodiscard]] bool is_identity() const { return input == output && repeat() == 1; }
  /// k if each input is an output k times over, one behind the other; else 0.
  [[nodiscard]] std::size_t repeat() const {
    if (output % input != 0) return 0;
    const std::size_t k = output / input;
    for (std::size_t i = 0; i < output; ++i) {
      double own = 0;
      for (std::size_t t = i * taps; t < (i + 1) * taps; ++t) {
        if (index[t] == i / k) own += weight[t];
        if (index[t] != i / k && weight[t] != 0) return 0;
      }
      if (own != 1) return 0;
    }
    return k;
  }
};

namespace detail {
/// Where output i lies among the inputs.
[[nodiscard]] inline double resize_coordinate(const ResizeRule& rule, const ResizeAxis& axis, std::size_t i) {
  const auto x = static_cast<double>(i), scale = axis.scale;
  const auto input = static_cast<double>(axis.input), output = static_cast<double>(axis.output);
  const std::string& mode = rule.coordinates;
  if (mode == "half_pixel") return (x + 0.5) / scale - 0.5;
  if (mode == "half_pixel_symmetric")
    return input / 2 * (1 - output / (scale * input)) + (x + 0.5) / scale - 0.5;
  if (mode == "pytorch_half_pixel") return output > 1 ? (x + 0.5) / scale - 0.5 : 0;
  if (mode == "align_corners") return output > 1 ? x * (input - 1) / (output - 1) : 0;
  if (mode == "asymmetric") return x / scale;
  if (mode == "tf_half_pixel_for_nn") return (x + 0.5) / scale;
  if (mode == "tf_crop_and_resize")
    return output > 1 ? axis.start * (input - 1) + x * (axis.end - axis.start) * (input - 1) / (output - 1)
                      : 0.5 * (axis.start + axis.end) * (input - 1);
  throw DomainError("attribute 'coordinate_transformation_mode' is " + in_quotes(mode));
}

[[nodiscard]] inline double nearest_input(const ResizeRule& rule, const ResizeAxis& axis, double x) {
  if (rule.nearest == "round_prefer_floor") return std::ceil(x - 0.5);
  if (rule.nearest == "round_prefer_ceil") return std::floor(x + 0.5);
  if (rule.nearest == "floor") return std::floor(x);
  if (rule.nearest == "ceil") return std::ceil(x);
  if (rule.nearest == "simple") return axis.scale < 1 ? std::ceil(x) : std::floor(x);
  throw DomainError("attribute 'nearest_mode' is " + in_quotes(rule.nearest));
}

/// Weights of the inputs ⌊x⌋ − 1 … ⌊x⌋ + 2 at x = ⌊x⌋ + t. Source: Keys, "Cubic convolution interpolation
/// for digital image processing" (1981), with a free.
inline void cubic_weights(double a, double t, double* weights) {
  const auto near = [a](double d) { return ((a + 2) * d - (a + 3)) * d * d + 1; };
  const auto far = [a](double d) { return ((a * d - 5 * a) * d + 8 * a) * d - 4 * a; };
  weights[0] = far(1 + t);
  weights[1] = near(t);
  weights[2] = near(1 - t);
  weights[3] = far(2 - t);
}
}  // namespace detail

/// \throws DomainError for a mode that is none
[[nodiscard]] inline ResizeTable resize_table(const ResizeRule& rule, const ResizeAxis& axis) {
  if (rule.mode != "nearest" && rule.mode != "linear" && rule.mode != "cubic")
    throw DomainError("attribute 'mode' is " + in_quotes(rule.mode));
  ResizeTable table{axis.axis, axis.input, axis.output, 1, {}, {}, {}};
  table.taps = rule.mode == "nearest" ? 1 : rule.mode == "linear" ? 2 : 4;
  const auto last = static_cast<double>(axis.input - 1);
  for (std::size_t i = 0; i < axis.output; ++i) {
    const double x = detail::resize_coordinate(rule, axis, i);
    double weights[4] = {1, 0, 0, 0};
    double first = std::floor(x);
    if (rule.mode == "nearest") first = detail::nearest_input(rule, axis, x);
    if (rule.mode == "linear") weights[0] = 1 - (x - first), weights[1] = x - first;
    if (rule.mode == "cubic") detail::cubic_weights(rule.cubic_a, x - first, weights), first -= 1;
    const bool is_outside = rule.coordinates == "tf_crop_and_resize" && (x < 0 || x > last);
    double sum = 0;
    for (std::size_t t = 0; t < table.taps; ++t) {
      const double place = first + static_cast<double>(t);
      if (is_outside || (rule.excludes_outside && rule.mode == "cubic" && (place < 0 || place > last)))
        weights[t] = 0;
      sum += weights[t];
      table.index.push_back(static_cast<std::size_t>(std::clamp(place, 0.0, last)));
    }
    for (std::size_t t = 0; t < table.taps; ++t)
      table.weight.push_back(rule.excludes_outside && sum != 0 ? weights[t] / sum : weights[t]);
    table.is_outside.push_back(is_outside);
  }
  return table;
}

}  // namespace tapestry::nn

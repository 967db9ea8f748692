#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/nn/detail/network/operator_context.hpp>
#include <vector>

namespace tapestry::nn {

/// Sampling rule of a resize: the attributes of Resize that hold for every axis.
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
  double start = 0, end = 1;  ///< range of tf_crop_and_resize, as shares of the axis
};

/// Output i is Σ weight[i · taps + t] · input[index[i · taps + t]] over t < taps.
struct ResizeTable {
  std::size_t axis = 0, input = 1, output = 1, taps = 1;
  std::vector<std::size_t> index{};
  std::vector<double> weight{};
  std::vector<bool> is_outside{};  ///< whether an output lies outside and has no weights

  [[nodiscard]] bool is_identity() const { return input == output && repeat() == 1; }
  /// k if the outputs are the inputs, each k times, one after another; else 0.
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
/// Coordinate of output i among the inputs.
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
  throw DomainError({"attribute 'coordinate_transformation_mode' is ", in_quotes(mode)});
}

[[nodiscard]] inline double nearest_input(const ResizeRule& rule, const ResizeAxis& axis, double x) {
  if (rule.nearest == "round_prefer_floor") return std::ceil(x - 0.5);
  if (rule.nearest == "round_prefer_ceil") return std::floor(x + 0.5);
  if (rule.nearest == "floor") return std::floor(x);
  if (rule.nearest == "ceil") return std::ceil(x);
  if (rule.nearest == "simple") return axis.scale < 1 ? std::ceil(x) : std::floor(x);
  throw DomainError({"attribute 'nearest_mode' is ", in_quotes(rule.nearest)});
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

/// \throws DomainError for a mode that is none, and for coordinates that are not finite
[[nodiscard]] inline ResizeTable resize_table(const ResizeRule& rule, const ResizeAxis& axis) {
  if (rule.mode != "nearest" && rule.mode != "linear" && rule.mode != "cubic")
    throw DomainError({"attribute 'mode' is ", in_quotes(rule.mode)});
  ResizeTable table{axis.axis, axis.input, axis.output, 1, {}, {}, {}};
  table.taps = rule.mode == "nearest" ? 1 : rule.mode == "linear" ? 2 : 4;
  const auto last = static_cast<double>(axis.input - 1);
  for (std::size_t i = 0; i < axis.output; ++i) {
    const double x = detail::resize_coordinate(rule, axis, i);
    if (!std::isfinite(x))
      throw DomainError(
          {"output ", i, " lies at ", x, " among the inputs; roi is ", axis.start, " to ", axis.end});
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

/// Attributes of a node Resize or Upsample.
struct ResizeAttributes {
  ResizeRule rule{};
  std::vector<ResizeAxis> axes{};
  double extrapolation = 0;
};

namespace detail {

/// Numbers of operand i, or none if it is left out or empty.
[[nodiscard]] inline std::vector<double> optional_numbers(const OperatorContext& context, std::size_t i) {
  if (!context.has_input(i) || size_of(context.input(i).shape) == 0) return {};
  const Constant& constant = context.constant(i);
  std::vector<double> values;
  for (std::size_t k = 0; k < constant.size(); ++k) values.push_back(constant.at(k));
  return values;
}

/// The axes, in the description's numbering, that scales and sizes are for.
[[nodiscard]] inline std::vector<std::int64_t> resized_axes(OperatorContext& context) {
  std::vector<std::int64_t> all(context.input(0).shape.size());
  std::iota(all.begin(), all.end(), std::int64_t(0));
  return context.integers("axes", all);
}

[[nodiscard]] inline std::size_t resized_extent(double value) {
  constexpr double most = 1 << 20;
  if (!(value >= 1 && value <= most)) throw ShapeError({"an extent would be ", value, " after resizing"});
  return static_cast<std::size_t>(value);
}

/// Extents from scales: ⌊extent · scale⌋, in single precision as in other runtimes.
inline void apply_scales(const std::vector<double>& scales, std::vector<ResizeAxis>& axes) {
  for (std::size_t k = 0; k < axes.size(); ++k) {
    if (!(scales[k] > 0) || !std::isfinite(scales[k])) throw DomainError({"a scale is ", scales[k]});
    axes[k].scale = scales[k];
    const float extent = static_cast<float>(axes[k].input) * static_cast<float>(scales[k]);
    axes[k].output = resized_extent(std::floor(static_cast<double>(extent)));
  }
}

/// Extents from sizes. A policy may apply the smallest or the largest scale to all axes.
inline void apply_sizes(const std::vector<double>& sizes, const std::string& policy,
                        std::vector<ResizeAxis>& axes) {
  std::vector<double> scales;
  for (std::size_t k = 0; k < axes.size(); ++k)
    scales.push_back(static_cast<double>(resized_extent(sizes[k])) / static_cast<double>(axes[k].input));
  if (policy != "stretch" && policy != "not_larger" && policy != "not_smaller")
    throw DomainError({"attribute 'keep_aspect_ratio_policy' is '", policy, "'"});
  const double common = policy == "not_larger" ? *std::min_element(scales.begin(), scales.end())
                                               : *std::max_element(scales.begin(), scales.end());
  for (std::size_t k = 0; k < axes.size(); ++k) {
    axes[k].output = resized_extent(sizes[k]);
    axes[k].scale = scales[k];
    if (policy == "stretch") continue;
    axes[k].output = resized_extent(std::floor(common * static_cast<double>(axes[k].input) + 0.5));
    axes[k].scale = common;
  }
}

[[nodiscard]] inline ResizeRule resize_rule(OperatorContext& context, bool is_early) {
  ResizeRule rule;
  rule.mode = context.text("mode", "nearest");
  if (rule.mode == "bilinear" || rule.mode == "trilinear") rule.mode = "linear";
  if (is_early) {
    rule.coordinates = "asymmetric";
    rule.nearest = "simple";
    return rule;
  }
  rule.coordinates = context.text("coordinate_transformation_mode", rule.coordinates);
  rule.nearest = context.text("nearest_mode", rule.nearest);
  rule.cubic_a = context.number("cubic_coeff_a", rule.cubic_a);
  rule.excludes_outside = context.integer("exclude_outside", 0) != 0;
  if (context.integer("antialias", 0) != 0) throw DomainError("attribute 'antialias' is not supported");
  return rule;
}
}  // namespace detail

/// \throws DomainError or ShapeError for attributes that are contradictory or not supported
[[nodiscard]] inline ResizeAttributes resize_attributes(OperatorContext& context) {
  const bool is_early = context.node().operation == "Upsample" || context.opset() < 11;
  ResizeAttributes attributes{detail::resize_rule(context, is_early), {}, 0};
  const Shape& shape = context.input(0).shape;
  if (size_of(shape) == 0) throw ShapeError("input 0 is empty");
  for (const std::int64_t axis : detail::resized_axes(context)) {
    const std::size_t stored = context.axis(axis, shape.size());
    const auto is_same = [stored](const ResizeAxis& other) { return other.axis == stored; };
    if (stored >= shape.size() || std::ranges::any_of(attributes.axes, is_same))
      throw DomainError({"axis ", axis, " is named twice, or of a scalar"});
    attributes.axes.push_back({stored, shape[stored], shape[stored], 1, 0, 1});
  }
  auto& axes = attributes.axes;
  const auto require_count = [&](const char* what, std::size_t count, std::size_t expected) {
    if (count != expected) throw ShapeError({what, " has ", count, " values, expected ", expected});
  };
  const bool has_attribute = context.has_attribute("scales");
  const auto scales =
      has_attribute ? context.numbers("scales") : detail::optional_numbers(context, is_early ? 1 : 2);
  const auto sizes = is_early ? std::vector<double>() : detail::optional_numbers(context, 3);
  const std::string policy = is_early ? "stretch" : context.text("keep_aspect_ratio_policy", "stretch");
  attributes.extrapolation = is_early ? 0 : context.number("extrapolation_value", 0);
  if (scales.empty() == sizes.empty()) throw DomainError("expected either scales or sizes");
  require_count(scales.empty() ? "sizes" : "scales", scales.size() + sizes.size(), axes.size());
  if (!scales.empty()) detail::apply_scales(scales, axes);
  if (!sizes.empty()) detail::apply_sizes(sizes, policy, axes);
  if (attributes.rule.coordinates != "tf_crop_and_resize") return attributes;
  const auto roi = detail::optional_numbers(context, 1);
  require_count("roi", roi.size(), 2 * axes.size());
  for (std::size_t k = 0; k < axes.size(); ++k) {
    axes[k].start = roi[k];
    axes[k].end = roi[axes.size() + k];
  }
  return attributes;
}

}  // namespace tapestry::nn

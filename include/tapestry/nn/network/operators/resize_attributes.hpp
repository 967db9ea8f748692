#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <numeric>
#include <string>
#include <tapestry/core/check.hpp>
#include <tapestry/nn/network/operator_context.hpp>
#include <tapestry/nn/network/operators/resize_axis.hpp>
#include <vector>

namespace tapestry::nn {

/// What a node of Resize or Upsample asks for.
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
  if (!(value >= 1 && value <= most))
    throw ShapeError("an extent would be " + std::to_string(value) + " after resizing");
  return static_cast<std::size_t>(value);
}

/// Extents from scales: ⌊extent · scale⌋, in single precision as others compute it.
inline void apply_scales(const std::vector<double>& scales, std::vector<ResizeAxis>& axes) {
  for (std::size_t k = 0; k < axes.size(); ++k) {
    if (!(scales[k] > 0) || !std::isfinite(scales[k]))
      throw DomainError("a scale is " + std::to_string(scales[k]));
    axes[k].scale = scales[k];
    const float extent = static_cast<float>(axes[k].input) * static_cast<float>(scales[k]);
    axes[k].output = resized_extent(std::floor(static_cast<double>(extent)));
  }
}

/// Extents from sizes, of which a policy may take the smallest or largest scale for all.
inline void apply_sizes(const std::vector<double>& sizes, const std::string& policy,
                        std::vector<ResizeAxis>& axes) {
  std::vector<double> scales;
  for (std::size_t k = 0; k < axes.size(); ++k)
    scales.push_back(static_cast<double>(resized_extent(sizes[k])) / static_cast<double>(axes[k].input));
  if (policy != "stretch" && policy != "not_larger" && policy != "not_smaller")
    throw DomainError("attribute 'keep_aspect_ratio_policy' is '" + policy + "'");
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

/// \throws DomainError or ShapeError for what makes no sense or is not supported
[[nodiscard]] inline ResizeAttributes resize_attributes(OperatorContext& context) {
  const bool is_early = context.node().operation == "Upsample" || context.opset() < 11;
  ResizeAttributes attributes{detail::resize_rule(context, is_early), {}, 0};
  const Shape& shape = context.input(0).shape;
  if (size_of(shape) == 0) throw ShapeError("input 0 is empty");
  for (const std::int64_t axis : detail::resized_axes(context)) {
    const std::size_t stored = context.axis(axis, shape.size());
    const auto is_same = [stored](const ResizeAxis& other) { return other.axis == stored; };
    if (stored >= shape.size() || std::ranges::any_of(attributes.axes, is_same))
      throw DomainError("axis " + std::to_string(axis) + " is named twice, or of a scalar");
    attributes.axes.push_back({stored, shape[stored], shape[stored], 1, 0, 1});
  }
  auto& axes = attributes.axes;
  const auto require_count = [&](const char* what, std::size_t count, std::size_t expected) {
    if (count != expected)
      throw ShapeError(std::string(what) + " has " + std::to_string(count) + " values, expected " +
                       std::to_string(expected));
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

#pragma once
#include <tapestry/nn/detail/network/operator_context.hpp>

namespace tapestry::nn {
/// Sampling rule of a resize: the attributes of Resize that hold for every axis.
/// Source: onnx.ai, Operators.md, Resize.
struct ResizeRule {
  std::string coordinates = "half_pixel";  ///< coordinate_transformation_mode
  std::string mode = "nearest";
  std::string nearest = "round_prefer_floor";  ///< or "simple": up before the 11th opset, down otherwise
  double cubic_a = -0.75;
  bool excludes_outside = false;
  bool antialiases = false;  ///< linear and cubic filters reach as far as an output pixel is large
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
/// Coordinate of output i among the inputs. Ties of the nearest value follow the extents: a scale that equals
/// their ratio, rounded to single precision as in files, counts as the exact ratio.
[[nodiscard]] inline double resize_coordinate(const ResizeRule& rule, const ResizeAxis& axis, std::size_t i) {
  const auto x = static_cast<double>(i), scale = axis.scale;
  const auto input = static_cast<double>(axis.input), output = static_cast<double>(axis.output);
  const std::string& mode = rule.coordinates;
  const bool is_ratio =
      rule.mode == "nearest" && static_cast<float>(scale) == static_cast<float>(output / input);
  const auto unscaled = [&](double place) { return is_ratio ? place * input / output : place / scale; };
  if (mode == "half_pixel") return unscaled(x + 0.5) - 0.5;
  if (mode == "half_pixel_symmetric") {
    const double margin = is_ratio ? 0 : input / 2 * (1 - output / (scale * input));
    return margin + unscaled(x + 0.5) - 0.5;
  }
  if (mode == "pytorch_half_pixel") return output > 1 ? unscaled(x + 0.5) - 0.5 : 0;
  if (mode == "align_corners") return output > 1 ? x * (input - 1) / (output - 1) : 0;
  if (mode == "asymmetric") return unscaled(x);
  if (mode == "tf_half_pixel_for_nn") return unscaled(x + 0.5);
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

/// The cubic filter at a distance. Source: Keys, "Cubic convolution interpolation for digital image
/// processing" (1981), with a free.
[[nodiscard]] inline double cubic_filter(double a, double distance) {
  const double d = std::abs(distance);
  if (d <= 1) return ((a + 2) * d - (a + 3)) * d * d + 1;
  return d < 2 ? ((a * d - 5 * a) * d + 8 * a) * d - 4 * a : 0;
}

/// Weights of the inputs ⌊x⌋ − 1 … ⌊x⌋ + 2 at x = ⌊x⌋ + t.
inline void cubic_weights(double a, double t, double* weights) {
  for (int k = 0; k < 4; ++k) weights[k] = cubic_filter(a, k < 2 ? t + (1 - k) : k - 1 - t);
}

/// The inputs that an output at x reads, and their weights.
struct ResizeTaps {
  double first = 0;
  std::vector<double> weights{};
};

[[nodiscard]] inline ResizeTaps resize_taps(const ResizeRule& rule, const ResizeAxis& axis, double x) {
  if (rule.mode == "nearest") return {nearest_input(rule, axis, x), {1}};
  const bool is_linear = rule.mode == "linear";
  const double below = std::floor(x), t = x - below, a = rule.cubic_a;
  if (!rule.antialiases || axis.scale >= 1) {
    if (is_linear) return {below, {1 - t, t}};
    ResizeTaps taps{below - 1, std::vector<double>(4)};
    cubic_weights(a, t, taps.weights.data());
    return taps;
  }
  const double reach = is_linear ? 1 : 2, start = std::floor(-reach / axis.scale) + 1;
  ResizeTaps taps{below + start, {}};
  for (double k = start; k < start + 2 * reach - 2 * start; ++k) {
    const double d = (k - t) * axis.scale;
    taps.weights.push_back(is_linear ? std::max(1 - std::abs(d), 0.0) : cubic_filter(a, d));
  }
  const double sum = std::accumulate(taps.weights.begin(), taps.weights.end(), 0.0);
  for (double& weight : taps.weights) weight /= sum;
  return taps;
}

/// Numbers of operand i, or none if it is left out or empty.
[[nodiscard]] inline std::vector<double> optional_numbers(const OperatorContext& context, std::size_t i) {
  if (!context.has_input(i) || size_of(context.input(i).shape) == 0) return {};
  const Constant& constant = context.constant(i);
  std::vector<double> values;
  for (std::size_t k = 0; k < constant.size(); ++k) values.push_back(constant.at(k));
  return values;
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
  const double common = policy == "not_larger" ? std::ranges::min(scales) : std::ranges::max(scales);
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
  rule.excludes_outside = context.flag("exclude_outside", 0);
  rule.antialiases = context.flag("antialias", 0);
  return rule;
}
}  // namespace detail

/// \throws DomainError for a mode that is none, and for coordinates that are not finite; ShapeError for a
///         filter that is larger than any tensor
[[nodiscard]] inline ResizeTable resize_table(const ResizeRule& rule, const ResizeAxis& axis) {
  if (rule.mode != "nearest" && rule.mode != "linear" && rule.mode != "cubic")
    throw DomainError({"attribute 'mode' is ", in_quotes(rule.mode)});
  const bool is_stretched = rule.antialiases && axis.scale < 1 && rule.mode != "nearest";
  if (is_stretched) require_room({axis.output, static_cast<std::size_t>(std::min(4 / axis.scale, 1e18)) + 4});
  ResizeTable table{axis.axis, axis.input, axis.output, 1, {}, {}, {}};
  const auto last = static_cast<double>(axis.input - 1);
  for (std::size_t i = 0; i < axis.output; ++i) {
    const double x = detail::resize_coordinate(rule, axis, i);
    if (!std::isfinite(x))
      throw DomainError(
          {"output ", i, " lies at ", x, " among the inputs; roi is ", axis.start, " to ", axis.end});
    auto [first, weights] = detail::resize_taps(rule, axis, x);
    table.taps = weights.size();
    const bool is_outside = rule.coordinates == "tf_crop_and_resize" && (x < 0 || x > last);
    const bool excludes = rule.excludes_outside && (rule.mode == "cubic" || is_stretched);
    double sum = 0;
    for (std::size_t t = 0; t < table.taps; ++t) {
      const double place = first + static_cast<double>(t);
      if (is_outside || (excludes && (place < 0 || place > last))) weights[t] = 0;
      sum += weights[t];
      table.index.push_back(static_cast<std::size_t>(std::clamp(place, 0.0, last)));
    }
    for (const double weight : weights)
      table.weight.push_back(rule.excludes_outside && sum != 0 ? weight / sum : weight);
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

/// \throws DomainError or ShapeError for attributes that are contradictory or not supported
[[nodiscard]] inline ResizeAttributes resize_attributes(OperatorContext& context) {
  const bool is_early = context.node().operation == "Upsample" || context.opset() < 11;
  ResizeAttributes attributes{detail::resize_rule(context, is_early), {}, 0};
  const Shape& shape = context.input(0).shape;
  if (size_of(shape) == 0) throw ShapeError("input 0 is empty");
  std::vector<std::int64_t> all(shape.size());
  std::iota(all.begin(), all.end(), std::int64_t(0));
  for (const std::int64_t axis : context.integers("axes", all)) {
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

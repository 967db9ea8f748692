#pragma once
#include <tapestry/detect/network_config.hpp>

namespace tapestry::detect {
namespace detail {
std::string to_text(const FeatureShape& shape) {
  return "[" + std::to_string(shape.channels) + ", " + std::to_string(shape.height) + ", " +
         std::to_string(shape.width) + "]";
}

/// Throws a limit error unless the product of the factors is at most largest_element_count.
inline void require_product(const NetworkConfig& config, const LayerConfig& layer, const char* what,
                            std::initializer_list<std::size_t> factors) {
  std::uint64_t product = 1;
  for (const std::size_t factor : factors) {
    if (__builtin_mul_overflow(product, std::uint64_t(factor), &product) || product > largest_element_count)
      throw cfg_error(config.name, layer.line, what,
                      "at most " + std::to_string(largest_element_count) + " elements", "", ErrorKind::limit);
  }
}

FileError misfit(const NetworkConfig& config, std::size_t index, const std::string& what,
                 const std::string& expected, const std::string& found) {
  const LayerConfig& layer = config.layers[index];
  return cfg_error(config.name, layer.line,
                   "layer " + std::to_string(index) + " (" + std::string(name_of(layer.kind)) + "): " + what,
                   expected, found, ErrorKind::mismatch);
}

/// Cells that a window of `extent` pixels visits along an axis.
[[nodiscard]] inline std::size_t window_count(const NetworkConfig& config, std::size_t index,
                                              std::size_t input, std::size_t total_padding,
                                              std::size_t extent) {
  const std::size_t stride = config.layers[index].stride;
  if (stride > input && stride > extent)
    throw cfg_error(config.name, config.layers[index].line, "stride larger than the input and the window",
                    "at most " + std::to_string(input), std::to_string(stride));
  if (input + total_padding < extent)
    throw misfit(config, index, "window larger than its padded input",
                 "at most " + std::to_string(input + total_padding), std::to_string(extent));
  return (input + total_padding - extent) / stride + 1;
}

inline void shape_windowed(const NetworkConfig& config, std::size_t index, FeatureShape& shape) {
  const LayerConfig& layer = config.layers[index];
  const bool is_pool = layer.kind == LayerKind::maxpool;
  const std::size_t padding = is_pool ? layer.padding : 2 * layer.padding;
  const std::size_t extent = layer.dilation * (layer.size - 1) + 1;
  shape.height = window_count(config, index, shape.height, padding, extent);
  shape.width = window_count(config, index, shape.width, padding, extent);
  shape.row_reduction *= static_cast<double>(layer.stride);
  shape.column_reduction *= static_cast<double>(layer.stride);
  if (is_pool) return;
  if (shape.channels % layer.groups != 0 || layer.filters % layer.groups != 0)
    throw misfit(config, index, "groups=" + std::to_string(layer.groups) + " does not divide its channels",
                 "a divisor of " + std::to_string(shape.channels) + " channels and " +
                     std::to_string(layer.filters) + " filters",
                 std::to_string(layer.groups));
  require_product(config, layer, "too many weights",
                  {shape.channels / layer.groups, layer.filters, layer.size, layer.size});
  shape.channels = layer.filters;
}

/// Shape of the layer named by "from", which the layer before multiplies by its factors.
[[nodiscard]] inline FeatureShape multiplied_shape(const NetworkConfig& config, std::size_t index,
                                                   const FeatureShape& factors,
                                                   const std::vector<FeatureShape>& shapes) {
  const LayerConfig& layer = config.layers[index];
  const FeatureShape& shape = shapes[layer.sources.front()];
  FeatureShape expected = shape;
  if (layer.kind == LayerKind::scale_channels && layer.scale_wh) expected.channels = 1;
  if (layer.kind == LayerKind::scale_channels && !layer.scale_wh) expected.height = expected.width = 1;
  if (factors.channels != expected.channels || factors.height != expected.height ||
      factors.width != expected.width)
    throw misfit(config, index,
                 "the layer before it has not one factor for each " +
                     std::string(layer.kind == LayerKind::sam ? "value"
                                 : layer.scale_wh             ? "pixel"
                                                              : "channel") +
                     " of layer " + std::to_string(layer.sources.front()),
                 to_text(expected), to_text(factors));
  return shape;
}

inline void shape_reorganised(const NetworkConfig& config, std::size_t index, FeatureShape& shape) {
  const std::size_t stride = config.layers[index].stride;
  const std::size_t divisor = config.layers[index].kind == LayerKind::reorg ? stride * stride : 1;
  if (shape.height % stride != 0 || shape.width % stride != 0 || shape.channels % divisor != 0) {
    const std::string text = std::to_string(stride);
    throw misfit(
        config, index, "stride=" + text + " does not divide its input",
        "channels that are a multiple of " + std::to_string(divisor) + ", height and width of " + text,
        to_text(shape));
  }
  shape.channels *= stride * stride;
  shape.height /= stride;
  shape.width /= stride;
  shape.row_reduction *= static_cast<double>(stride);
  shape.column_reduction *= static_cast<double>(stride);
}

[[nodiscard]] inline FeatureShape joined_shape(const NetworkConfig& config, std::size_t index,
                                               const std::vector<FeatureShape>& shapes) {
  const LayerConfig& layer = config.layers[index];
  FeatureShape joined = shapes[layer.sources.front()];
  joined.channels = 0;
  for (const std::size_t source : layer.sources) {
    const FeatureShape& shape = shapes[source];
    if (shape.height != joined.height || shape.width != joined.width)
      throw misfit(
          config, index, "its sources differ in height or width; is the input a multiple of the stride?",
          to_text(shapes[layer.sources.front()]) + " as layer " + std::to_string(layer.sources.front()),
          to_text(shape) + " of layer " + std::to_string(source));
    if (shape.channels % layer.groups != 0)
      throw misfit(config, index, "groups does not divide the channels of layer " + std::to_string(source),
                   "a divisor of " + std::to_string(shape.channels), std::to_string(layer.groups));
    joined.channels += shape.channels / layer.groups;
  }
  return joined;
}

Head head_of(const LayerConfig& layer, const FeatureShape& shape) {
  Head head{layer.classes, shape.height, shape.width, layer.anchors, layer.scale_x_y, layer.decode};
  head.exclusive_classes = layer.exclusive_classes;
  if (layer.kind == LayerKind::region)
    for (auto& [width, height] : head.anchors) {
      width *= shape.column_reduction;
      height *= shape.row_reduction;
    }
  return head;
}

inline void check_head(const NetworkConfig& config, std::size_t index, const FeatureShape& shape,
                       std::size_t height, std::size_t width) {
  const LayerConfig& layer = config.layers[index];
  const std::size_t needed = head_of(layer, shape).channel_count();
  if (shape.channels != needed)
    throw misfit(config, index,
                 std::to_string(layer.anchors.size()) + " anchors of 5 + " + std::to_string(layer.classes) +
                     " classes do not match the filters before it",
                 std::to_string(needed) + " channels", std::to_string(shape.channels));
  const auto fits = [](std::size_t input, std::size_t cells, double reduction) {
    return static_cast<double>(cells) * reduction == static_cast<double>(input);
  };
  if (!fits(height, shape.height, shape.row_reduction) || !fits(width, shape.width, shape.column_reduction)) {
    const double side =
        shape.row_reduction;  // below 1 behind upsampling, beyond any input behind many strides
    const bool is_count = side >= 1 && side <= 65536;
    throw misfit(config, index, "the input does not divide into its cells",
                 "height and width that are multiples of " +
                     (is_count ? std::to_string(static_cast<long>(side)) : "the strides before it"),
                 std::to_string(height) + " x " + std::to_string(width));
  }
}

/// \throws FileError (mismatch) unless each source of a shortcut can be added to the layer before it
inline void require_addable(const NetworkConfig& config, std::size_t index, const FeatureShape& shape,
                            const std::vector<FeatureShape>& shapes) {
  const auto is_multiple = [](std::size_t a, std::size_t b) { return std::max(a, b) % std::min(a, b) == 0; };
  for (const std::size_t source : config.layers[index].sources) {
    const FeatureShape& other = shapes[source];
    if (!is_multiple(other.height, shape.height) || !is_multiple(other.width, shape.width) ||
        other.height * shape.width != other.width * shape.height)
      throw misfit(config, index,
                   "cannot add layers of which neither has a whole multiple of the other's height and width",
                   to_text(shape) + " as layer " + std::to_string(index - 1),
                   to_text(other) + " of layer " + std::to_string(source));
  }
}

[[nodiscard]] inline FeatureShape shape_of_layer(const NetworkConfig& config, std::size_t index,
                                                 const FeatureShape& before,
                                                 const std::vector<FeatureShape>& shapes) {
  const LayerConfig& layer = config.layers[index];
  FeatureShape shape = before;
  switch (layer.kind) {
    case LayerKind::convolutional:
    case LayerKind::maxpool:
      shape_windowed(config, index, shape);
      break;
    case LayerKind::upsample:
      shape.height *= layer.stride;
      shape.width *= layer.stride;
      shape.row_reduction /= static_cast<double>(layer.stride);
      shape.column_reduction /= static_cast<double>(layer.stride);
      break;
    case LayerKind::route:
      return joined_shape(config, index, shapes);
    case LayerKind::shortcut:
      require_addable(config, index, shape, shapes);
      break;
    case LayerKind::avgpool:
      shape.row_reduction *= static_cast<double>(shape.height);
      shape.column_reduction *= static_cast<double>(shape.width);
      shape.height = shape.width = 1;
      break;
    case LayerKind::softmax:
      if (shape.size() % layer.groups != 0)
        throw misfit(config, index, "groups does not divide its input", "", "");
      break;
    case LayerKind::scale_channels:
    case LayerKind::sam:
      return multiplied_shape(config, index, before, shapes);
    case LayerKind::reorg:
    case LayerKind::reorg3d:
      shape_reorganised(config, index, shape);
      break;
    case LayerKind::yolo:
    case LayerKind::region:
    case LayerKind::dropout:
      break;
  }
  return shape;
}
}  // namespace detail

std::vector<FeatureShape> infer_shapes(const NetworkConfig& config, std::size_t height, std::size_t width) {
  if (height == 0 || width == 0 || height > 16384 || width > 16384)
    throw cfg_error(config.name, config.line, "input size out of range", "1 to 16384 pixels a side",
                    std::to_string(height) + " x " + std::to_string(width), ErrorKind::limit);
  std::vector<FeatureShape> shapes;
  FeatureShape image{config.channels, height, width};
  for (std::size_t i = 0; i < config.layers.size(); ++i) {
    const LayerConfig& layer = config.layers[i];
    for (const std::size_t input : inputs_of(config, i)) {
      const LayerKind kind = config.layers[input].kind;
      if (is_head(kind))
        throw detail::misfit(config, i,
                             "reads from a [" + std::string(name_of(kind)) + "] layer, which has no output",
                             "another layer", "layer " + std::to_string(input));
    }
    const FeatureShape shape = detail::shape_of_layer(config, i, i > 0 ? shapes.back() : image, shapes);
    detail::require_product(config, layer, "output too large", {shape.channels, shape.height, shape.width});
    if (is_head(layer.kind)) detail::check_head(config, i, shape, height, width);
    shapes.push_back(shape);
  }
  return shapes;
}
}  // namespace tapestry::detect

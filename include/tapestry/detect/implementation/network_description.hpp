#pragma once
#include <tapestry/detect/darknet_model.hpp>

namespace tapestry::detect {
namespace detail {
/// Adds nodes and constants to a description, named by the layer that they belong to.
class DescriptionWriter {
 public:
  using Attributes = std::map<std::string, nn::Attribute>;
  using Integers = std::vector<std::int64_t>;

  [[nodiscard]] static std::string name_of_layer(std::size_t i) { return "layer_" + std::to_string(i); }
  [[nodiscard]] static std::int64_t integer(std::size_t count) { return static_cast<std::int64_t>(count); }

  /// Adds a node to the layer that is being described. \returns the name of its result
  std::string add(const std::string& operation, std::vector<std::string> inputs, Attributes attributes = {}) {
    const std::string result = name_of_layer(layer_) + "." + std::to_string(network.nodes.size());
    network.nodes.push_back({result, operation, std::move(inputs), {result}, std::move(attributes)});
    return result;
  }

  std::string add_constant(const std::string& suffix, nn::Constant constant) {
    std::string name = name_of_layer(layer_) + suffix;
    while (network.constants.contains(name)) name += '\'';
    network.constants[name] = std::move(constant);
    return name;
  }
  std::string add_integers(const std::string& suffix, const Integers& integers) {
    return add_constant(
        suffix,
        {{integers.size()}, nn::ElementType::integer, std::vector<double>(integers.begin(), integers.end())});
  }
  std::string add_number(const std::string& suffix, double number) {
    return add_constant(suffix, {{}, nn::ElementType::floating, std::vector<double>{number}});
  }
  std::string slice(const std::string& input, const Integers& axes, const std::vector<std::size_t>& begins,
                    const std::vector<std::size_t>& ends, const std::vector<std::size_t>& steps) {
    const auto all = [&](const std::string& suffix, const std::vector<std::size_t>& values) {
      return add_integers(suffix, Integers(values.begin(), values.end()));
    };
    return add("Slice", {input, all(".begins", begins), all(".ends", ends), add_integers(".axes", axes),
                         all(".steps", steps)});
  }

  std::string pad(const std::string& value, Integers zeros, const Integers& after) {
    zeros.insert(zeros.end(), after.begin(), after.end());
    return add("Pad", {value, add_integers(".zeros", zeros)});
  }

  nn::NetworkDescription network{};
  std::size_t layer_ = 0;  ///< index of the layer being described
};

template <std::floating_point T>
class CfgDescriber : DescriptionWriter {
 public:
  CfgDescriber(const NetworkConfig& config, const Array<T, 1>& parameters, std::size_t height,
               std::size_t width, bool batch_statistics, bool borrows)
      : config_(config),
        batch_statistics_(batch_statistics),
        borrows_(borrows),
        parameters_(parameters),
        shapes_(infer_shapes(config, height, width)),
        layout_(parameter_layout(config, shapes_)) {
    require_shape("network_description", "parameters", parameters, {layout_.count});
    image_ = {config.channels, height, width};
    network.path = config.name;
    network.opset = 18;  // the first that has Mish
    network.inputs = {{"picture", {1, config.channels, height, width}}};
  }

  [[nodiscard]] nn::NetworkDescription describe() && {
    for (std::size_t i = 0; i < config_.layers.size(); ++i) {
      layer_ = i;
      const std::size_t before = network.nodes.size();
      const std::string made = add_layer(i);
      const bool makes_value = network.nodes.size() > before;
      if (makes_value) network.nodes.back().outputs.front() = name_of_layer(i);
      values_.push_back(makes_value ? name_of_layer(i) : made);
      if (is_head(config_.layers[i].kind)) network.outputs.push_back(values_.back());
    }
    if (network.outputs.empty()) network.outputs = {values_.empty() ? "picture" : values_.back()};
    network.outputs.insert(network.outputs.end(), statistics_.begin(), statistics_.end());
    return std::move(network);
  }

 private:
  [[nodiscard]] std::vector<std::pair<std::string, FeatureShape>> inputs_of(std::size_t i) const {
    std::vector<std::pair<std::string, FeatureShape>> inputs;
    for (const std::size_t input : detect::inputs_of(config_, i))
      inputs.emplace_back(values_[input], shapes_[input]);
    if (inputs.empty()) inputs.emplace_back("picture", image_);
    return inputs;
  }

  std::string add_parameters(ParameterRole role, std::size_t offset, nn::Shape shape) {
    const T* const first = parameters_.data() + offset;
    const std::size_t count = nn::size_of(shape);
    const std::string name = constant_name({layer_, role, offset, count});
    nn::Constant& constant = network.constants[name] = {std::move(shape), nn::ElementType::floating};
    if constexpr (std::is_same_v<T, float>)
      if (borrows_) constant.values = nn::BorrowedValues{{first, count}};
    if (!borrows_) constant.values = std::vector<T>(first, first + count);
    return name;
  }

  std::string add_layer(std::size_t i) {
    const LayerConfig& layer = config_.layers[i];
    const auto inputs = inputs_of(i);
    const auto& [input, shape] = inputs.front();
    using Kind = LayerKind;
    switch (layer.kind) {
      case Kind::convolutional:
        return activate(layer.activation, convolve(i, input, shape));
      case Kind::maxpool:
        return pool(layer, input);
      case Kind::upsample:
        return upsample(layer, input);
      case Kind::route:
        return join(layer, inputs);
      case Kind::shortcut:
        return activate(layer.activation, add_up(i, inputs));
      case Kind::avgpool:
        return add("GlobalAveragePool", {input});
      case Kind::softmax:
        return softmax(layer, input, shape);
      case Kind::scale_channels:
      case Kind::sam:
        return activate(layer.activation, add("Mul", {inputs.back().first, input}));
      case Kind::reorg:
        return reorganise(layer, input, shape);
      case Kind::reorg3d:
        return add("SpaceToDepth", {input}, {{"blocksize", integer(layer.stride)}});
      case Kind::yolo:
      case Kind::region:
      case Kind::dropout:
        break;
    }
    return input;
  }

  std::string convolve(std::size_t i, const std::string& input, const FeatureShape& shape) {
    const LayerConfig& layer = config_.layers[i];
    const ConvolutionParameters& own = layout_.layers[i];
    const std::size_t filters = layer.filters, size = layer.size;
    std::vector<std::string> operands{input,
                                      add_parameters(ParameterRole::weight, own.weight,
                                                     {filters, shape.channels / layer.groups, size, size})};
    const std::string biases = add_parameters(ParameterRole::bias, own.bias, {filters});
    if (!layer.batch_normalize) operands.push_back(biases);
    const std::string sums = add("Conv", std::move(operands),
                                 {{"kernel_shape", Integers(2, integer(size))},
                                  {"strides", Integers(2, integer(layer.stride))},
                                  {"pads", Integers(4, integer(layer.padding))},
                                  {"dilations", Integers(2, integer(layer.dilation))},
                                  {"group", integer(layer.groups)}});
    if (!layer.batch_normalize) return sums;
    const std::string normalised = add("BatchNormalization",
                                       {sums, add_parameters(ParameterRole::scale, own.scale, {filters}),
                                        biases, add_parameters(ParameterRole::mean, own.mean, {filters}),
                                        add_parameters(ParameterRole::variance, own.variance, {filters})},
                                       {{"epsilon", config_.batch_norm_epsilon}});
    if (batch_statistics_) hand_out_statistics();
    return normalised;
  }

  /// Makes the last batch normalisation take the batch's statistics and return them: with a momentum of 0 the
  /// running ones become these.
  void hand_out_statistics() {
    nn::Node& node = network.nodes.back();
    node.attributes["training_mode"] = std::int64_t(1);
    node.attributes["momentum"] = 0.0;
    for (const char* suffix : {".batch_means", ".batch_variances"}) {
      statistics_.push_back(name_of_layer(layer_) + suffix);
      node.outputs.push_back(statistics_.back());
    }
  }

  std::string activate(nn::Activation activation, const std::string& value) {
    constexpr std::array<const char*, nn::activations.size()> operations{
        "", "LeakyRelu", "Relu", "Sigmoid", "Mul", "Mish", "HardMish", "Clip", "Elu", "Tanh"};
    const std::string operation = operations[static_cast<std::size_t>(activation)];
    if (activation == nn::Activation::linear) return value;
    if (activation == nn::Activation::leaky) return add(operation, {value}, {{"alpha", 0.1}});
    if (activation == nn::Activation::swish) return add(operation, {value, add("Sigmoid", {value})});
    if (activation == nn::Activation::relu6)
      return add(operation, {value, add_number(".least", 0), add_number(".most", 6)});
    return add(operation, {value});
  }

  std::string pool(const LayerConfig& layer, const std::string& input) {
    const std::int64_t before = integer(layer.padding / 2), after = integer(layer.padding) - before;
    return add("MaxPool", {input},
               {{"kernel_shape", Integers(2, integer(layer.size))},
                {"strides", Integers(2, integer(layer.stride))},
                {"pads", Integers{before, before, after, after}}});
  }

  std::string upsample(const LayerConfig& layer, const std::string& input) {
    const auto factor = static_cast<double>(layer.stride);
    const std::string factors = add_constant(
        ".factors", {{4}, nn::ElementType::floating, std::vector<float>{1, 1, float(factor), float(factor)}});
    const std::string larger = add("Resize", {input, "", factors},
                                   {{"mode", std::string("nearest")},
                                    {"coordinate_transformation_mode", std::string("asymmetric")},
                                    {"nearest_mode", std::string("floor")}});
    return layer.scale == 1 ? larger : add("Mul", {larger, add_number(".scale", layer.scale)});
  }

  std::string join(const LayerConfig& layer,
                   const std::vector<std::pair<std::string, FeatureShape>>& inputs) {
    std::vector<std::string> parts;
    for (const auto& [input, shape] : inputs) {
      const std::size_t count = shape.channels / layer.groups;
      parts.push_back(layer.groups == 1
                          ? input
                          : slice(input, {1}, {layer.group * count}, {(layer.group + 1) * count}, {1}));
    }
    return parts.size() == 1 ? parts.front() : add("Concat", parts, {{"axis", std::int64_t(1)}});
  }

  std::string add_up(std::size_t i, const std::vector<std::pair<std::string, FeatureShape>>& inputs) {
    std::string sum = inputs.front().first;
    for (std::size_t k = 1; k < inputs.size(); ++k)
      sum = add("Add", {sum, fitted(inputs[k].first, inputs[k].second, shapes_[i])});
    return inputs.size() > 1 ? sum : add("Identity", {sum});
  }

  /// Fits a source of a shortcut to the extents of the sum: the smaller number of channels; along an
  /// axis where one has f times the other's pixels, every f-th pixel from the first. Source:
  /// shortcut_cpu of pjreddie's Darknet.
  std::string fitted(std::string value, const FeatureShape& from, const FeatureShape& to) {
    const std::size_t rows = std::min(from.height, to.height), columns = std::min(from.width, to.width);
    const std::size_t channels = std::min(from.channels, to.channels);
    if (channels < from.channels || rows < from.height || columns < from.width)
      value = slice(value, {1, 2, 3}, {0, 0, 0}, {channels, from.height, from.width},
                    {1, from.height / rows, from.width / columns});
    if (rows < to.height || columns < to.width) {
      const std::int64_t down = integer(to.height / rows), right = integer(to.width / columns);
      const std::int64_t c = integer(channels), h = integer(rows), w = integer(columns);
      value = add("Reshape", {value, add_integers(".pixels", {0, c, h, 1, w, 1})});
      value = pad(value, {0, 0, 0, 0, 0, 0}, {0, 0, 0, down - 1, 0, right - 1});
      value = add("Reshape", {value, add_integers(".blocks", {0, c, h * down, w * right})});
    }
    return channels < to.channels ? pad(value, {0, 0, 0, 0}, {0, integer(to.channels - channels), 0, 0})
                                  : value;
  }

  std::string softmax(const LayerConfig& layer, std::string value, const FeatureShape& shape) {
    if (layer.temperature != 1) value = add("Div", {value, add_number(".temperature", layer.temperature)});
    const std::int64_t c = integer(shape.channels), h = integer(shape.height), w = integer(shape.width);
    value = add("Reshape", {value, add_integers(".runs", {0, integer(layer.groups), -1})});
    value = add("Softmax", {value}, {{"axis", std::int64_t(2)}});
    return add("Reshape", {value, add_integers(".channels", {0, c, h, w})});
  }

  /// Darknet's order: [C', s·H, s·W] read as [C', H, s, W, s], turned to [s, s, C', H, W].
  std::string reorganise(const LayerConfig& layer, std::string value, const FeatureShape& shape) {
    const std::int64_t s = integer(layer.stride);
    const std::int64_t c = integer(shape.channels), h = integer(shape.height), w = integer(shape.width);
    value = add("Reshape", {value, add_integers(".blocks", {0, c / (s * s), h, s, w, s})});
    value = add("Transpose", {value}, {{"perm", Integers{0, 3, 5, 1, 2, 4}}});
    return add("Reshape", {value, add_integers(".channels", {0, c * s * s, h / s, w / s})});
  }

  const NetworkConfig& config_;
  bool batch_statistics_, borrows_;
  const Array<T, 1>& parameters_;
  std::vector<FeatureShape> shapes_;
  ParameterLayout layout_;
  FeatureShape image_{};
  std::vector<std::string> values_{};      ///< of the layers so far
  std::vector<std::string> statistics_{};  ///< names
};
}  // namespace detail

template <std::floating_point T>
nn::NetworkDescription network_description(const NetworkConfig& config, const Array<T, 1>& parameters,
                                           std::size_t input_height, std::size_t input_width,
                                           bool batch_statistics, bool borrows) {
  return detail::CfgDescriber<T>(config, parameters, input_height == 0 ? config.height : input_height,
                                 input_width == 0 ? config.width : input_width, batch_statistics, borrows)
      .describe();
}
}  // namespace tapestry::detect

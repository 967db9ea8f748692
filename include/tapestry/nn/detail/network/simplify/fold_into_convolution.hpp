#pragma once
#include <tapestry/nn/detail/network/simplify/merge_patterns.hpp>

namespace tapestry::nn {
namespace detail {
/// The slope of a LeakyRelu, or of a PRelu applied to `value` with one slope for all channels; otherwise NaN.
[[nodiscard]] inline double common_slope(const EditableGraph& graph, const Node& node,
                                         const std::string& value) {
  if (node.operation == "LeakyRelu") return attribute_of(node, "alpha", 0.01);
  const Constant* slopes = node.inputs[0] == value ? graph.constant(node.inputs[1]) : nullptr;
  constexpr double none = std::numeric_limits<double>::quiet_NaN();
  if (slopes == nullptr || slopes->size() == 0) return none;
  for (std::size_t i = 1; i < slopes->size(); ++i)
    if (slopes->at(i) != slopes->at(0)) return none;
  return slopes->at(0);
}

/// Adds a node's activation to a FusedConv that has none. \returns whether it could
[[nodiscard]] inline bool take_activation(const EditableGraph& graph, const Node& node, Node& fused) {
  double a = 0, b = 0;
  std::string name = node.operation;
  if (name == "LeakyRelu" || name == "PRelu") {
    a = common_slope(graph, node, fused.outputs[0]);
    name = "LeakyRelu";
    if (!(a >= 0)) return false;
  } else if (name == "HardSigmoid") {
    a = attribute_of(node, "alpha", 0.2);
    b = attribute_of(node, "beta", 0.5);
  } else if (name == "HardSwish") {
    a = 1.0 / 6;
    b = 0.5;
  } else if (name == "Clip") {
    a = -std::numeric_limits<double>::infinity();
    b = -a;
    if (!read_bound(graph, node, 0, a) || !read_bound(graph, node, 1, b) || !(a <= b)) return false;
  } else if (name == "Swish") {
    if (attribute_of(node, "alpha", 1.0) != 1) return false;
  } else if (name != "Relu" && name != "Sigmoid" && name != "Mish") {
    return false;
  }
  fused.attributes["activation"] = name;
  fused.attributes["activation_a"] = a;
  fused.attributes["activation_b"] = b;
  return true;
}

/// Adds another tensor of the same extents, if it is computed before the convolution. \returns whether it
/// could
[[nodiscard]] inline bool take_addend(const EditableGraph& graph, const Node& sum, const std::string& value,
                                      std::size_t convolution, Node& fused) {
  if (sum.operation != "Add" || !fused.inputs[1].empty()) return false;
  const std::string& other = other_operand(sum, value);
  const std::size_t maker = graph.maker(other);
  if (other == value || graph.constant(other) != nullptr || !graph.have_same_shape(value, other))
    return false;
  if (maker != EditableGraph::none && maker > convolution) return false;
  fused.inputs[1] = other;
  return true;
}

/// Fuses into convolution i the nodes behind it, while each is the only reader of the one before.
inline void fuse_convolution(EditableGraph& graph, std::size_t i) {
  if (!graph.is(i, "Conv")) return;
  Node fused = graph.node(i);
  fused.operation = "FusedConv";
  fused.inputs.insert(fused.inputs.begin() + 1, "");
  std::size_t place = i;
  bool has_activation = false;
  while (true) {
    const std::string value = fused.outputs[0];
    const std::size_t reader = graph.only_reader(value);
    if (reader == EditableGraph::none) break;
    const Node node = graph.node(reader);
    if (!has_activation && take_activation(graph, node, fused)) {
      has_activation = true;
      if (!fused.inputs[1].empty()) fused.attributes["adds_first"] = std::int64_t(1);
    } else if (!take_addend(graph, node, value, i, fused)) {
      break;
    }
    fused.outputs = node.outputs;
    graph.remove(place);
    graph.replace(reader, fused);
    place = reader;
  }
}
}  // namespace detail

/// Fuses activations and additions into the convolutions before them.
inline void fuse_convolutions(EditableGraph& graph) {
  for (std::size_t i = 0; i < graph.size(); ++i) detail::fuse_convolution(graph, i);
}

namespace detail {
/// y = factor · x + shift for each channel.
struct ChannelScaling {
  std::vector<double> factor{};
  std::vector<double> shift{};
};

/// Values of a constant for each of `channels` along axis 1 of `rank`, if it is repeated along all others.
[[nodiscard]] inline std::optional<std::vector<double>> channel_values(const Constant& constant,
                                                                       std::size_t channels,
                                                                       std::size_t rank) {
  Shape shape = constant.shape;
  if (shape.size() > rank) return {};
  shape.insert(shape.begin(), rank - shape.size(), 1);
  for (std::size_t axis = 0; axis < rank; ++axis)
    if (shape[axis] != 1 && !(axis == 1 && shape[axis] == channels)) return {};
  std::vector<double> values(channels);
  for (std::size_t c = 0; c < channels; ++c) values[c] = constant.at(shape[1] == 1 ? 0 : c);
  return values;
}

/// The channel scaling that node i applies to operand `value` of `channels`; nothing if it does something
/// else.
[[nodiscard]] inline std::optional<ChannelScaling> scaling_of(const EditableGraph& graph, std::size_t i,
                                                              const std::string& value, std::size_t channels,
                                                              std::size_t rank) {
  const Node& node = graph.node(i);
  ChannelScaling scaling{std::vector<double>(channels, 1), std::vector<double>(channels, 0)};
  if (node.operation == "BatchNormalization") {
    const double epsilon = attribute_of(node, "epsilon", 1e-5);
    if (node.inputs.size() != 5 || node.inputs[0] != value) return {};
    if (attribute_of<std::int64_t>(node, "training_mode", 0) != 0) return {};
    for (std::size_t k = 1; k < 5; ++k) {
      const Constant* known = graph.constant(node.inputs[k]);
      if (known == nullptr || known->size() != channels) return {};
    }
    const auto at = [&](std::size_t k, std::size_t c) { return graph.constant(node.inputs[k])->at(c); };
    for (std::size_t c = 0; c < channels; ++c) {
      scaling.factor[c] = at(1, c) / std::sqrt(at(4, c) + epsilon);
      scaling.shift[c] = at(2, c) - scaling.factor[c] * at(3, c);
    }
    return scaling;
  }
  if (node.inputs.size() != 2) return {};
  const bool is_first = node.inputs[0] == value;
  const Constant* known = graph.constant(node.inputs[is_first ? 1 : 0]);
  if (known == nullptr || !graph.have_same_shape(value, node.outputs[0])) return {};
  const auto values = channel_values(*known, channels, rank);
  if (!values) return {};
  for (std::size_t c = 0; c < channels; ++c) {
    if (node.operation == "Mul") scaling.factor[c] = (*values)[c];
    if (node.operation == "Div") scaling.factor[c] = 1 / (*values)[c];
    if (node.operation == "Add") scaling.shift[c] = (*values)[c];
    if (node.operation == "Sub") scaling.shift[c] = is_first ? -(*values)[c] : (*values)[c];
    if (node.operation == "Sub" && !is_first) scaling.factor[c] = -1;
  }
  const bool is_scaling = node.operation == "Mul" || node.operation == "Add" || node.operation == "Sub" ||
                          (node.operation == "Div" && is_first);
  return is_scaling ? std::optional(std::move(scaling)) : std::nullopt;
}

/// A constant's values, each times the factor of its channel, as numbers of type T.
template <std::floating_point T, class ChannelOf>
[[nodiscard]] Constant scaled(const Constant& constant, const std::vector<double>& factors,
                              ChannelOf channel_of) {
  if constexpr (std::is_same_v<T, float>)
    if (const auto* const borrowed = std::get_if<BorrowedValues>(&constant.values);
        borrowed != nullptr && borrowed->factors.empty() && channel_of.is_row())
      return {constant.shape, constant.type, BorrowedValues{borrowed->numbers, factors}};
  std::vector<T> values(constant.size());
  std::visit(
      [&](const auto& all) {
        for (std::size_t i = 0; i < values.size(); ++i)
          values[i] = static_cast<T>(static_cast<double>(all[i]) * factors[channel_of(i)]);
      },
      constant.values);
  return {constant.shape, constant.type, std::move(values)};
}

/// The output channel of a weight of a convolution, its transpose or a Gemm, by the weight's place.
class ChannelOfWeight {
 public:
  ChannelOfWeight(const Node& node, const Shape& weights)
      : is_transposed_(node.operation == "ConvTranspose"),
        of_first_(size_of(weights) / weights[0]),
        channels_(weights[1]) {
    if (node.operation == "Gemm" && attribute_of<std::int64_t>(node, "transB", 0) == 0) of_first_ = 0;
    if (!is_transposed_) return;
    of_group_ = weights[0] / static_cast<std::size_t>(attribute_of<std::int64_t>(node, "group", 1));
    of_channel_ = of_first_ / weights[1];
  }

  /// Whether the channel is the place along axis 0.
  [[nodiscard]] bool is_row() const { return !is_transposed_ && of_first_ != 0; }

  [[nodiscard]] std::size_t operator()(std::size_t i) const {
    if (is_transposed_) return i / of_first_ / of_group_ * channels_ + i % of_first_ / of_channel_;
    return of_first_ != 0 ? i / of_first_ : i % channels_;
  }

 private:
  bool is_transposed_;
  std::size_t of_first_;  ///< weights for each extent of axis 0; 0 where axis 1 counts channels
  std::size_t channels_;
  std::size_t of_group_ = 1, of_channel_ = 1;
};

/// A node's bias for each channel, times beta of a Gemm; zeros if it has none.
[[nodiscard]] inline std::optional<std::vector<double>> bias_of(const EditableGraph& graph, const Node& node,
                                                                std::size_t channels) {
  if (node.inputs.size() < 3 || node.inputs[2].empty()) return std::vector<double>(channels, 0);
  const Constant* known = graph.constant(node.inputs[2]);
  if (known == nullptr) return {};
  const bool is_gemm = node.operation == "Gemm";
  Constant row = *known;
  if (!is_gemm) row.shape.insert(row.shape.begin(), 1);
  auto values = channel_values(row, channels, 2);
  const double beta = is_gemm ? attribute_of(node, "beta", 1.0) : 1;
  if (values)
    for (double& value : *values) value *= beta;
  return values;
}

/// Whether a scaling can be folded into the node: a Conv, ConvTranspose or Gemm with constant weights.
[[nodiscard]] inline bool takes_scaling(const EditableGraph& graph, const Node& node) {
  const bool is_kind =
      node.operation == "Conv" || node.operation == "ConvTranspose" || node.operation == "Gemm";
  if (!is_kind || node.inputs.size() < 2) return false;
  const Constant* weights = graph.constant(node.inputs[1]);
  return weights != nullptr && weights->size() > 0;
}

/// Folds the only reader of node i into the node's weights if it scales channels. \returns whether it did
inline bool fold_scaling(EditableGraph& graph, std::size_t i) {
  if (!takes_scaling(graph, graph.node(i))) return false;
  const std::string value = graph.node(i).outputs[0];
  const std::size_t reader = graph.only_reader(value);
  const Shape* shape = graph.shape(value);
  if (reader == EditableGraph::none || shape == nullptr || shape->size() < 2) return false;
  const std::size_t channels = (*shape)[1];
  const auto scaling = scaling_of(graph, reader, value, channels, shape->size());
  if (!scaling) return false;
  auto bias = bias_of(graph, graph.node(i), channels);
  if (!bias) return false;
  Node node = graph.node(i);
  const std::string weights_name = node.inputs[1];
  const Constant& weights = *graph.constant(weights_name);
  for (std::size_t c = 0; c < channels; ++c) (*bias)[c] = (*bias)[c] * scaling->factor[c] + scaling->shift[c];
  const std::string where = " with " + graph.node(reader).outputs[0];
  const std::string bias_name = node.inputs.size() > 2 && !node.inputs[2].empty() ? node.inputs[2] : "bias";
  node.inputs.resize(3);
  node.inputs[2] =
      graph.add_constant(bias_name + where, {{channels}, ElementType::floating, std::move(*bias)});
  const ChannelOfWeight channel_of(node, weights.shape);
  node.inputs[1] = graph.add_constant(
      weights_name + where, graph.in_float() ? scaled<float>(weights, scaling->factor, channel_of)
                                             : scaled<double>(weights, scaling->factor, channel_of));
  if (node.operation == "Gemm") node.attributes["beta"] = 1.0;
  node.outputs = graph.node(reader).outputs;
  graph.remove(i);
  graph.replace(reader, std::move(node));
  graph.release(weights_name);
  return true;
}
}  // namespace detail

/// Folds batch normalisations and constants that scale or shift channels into the weights before them, in
/// double. Constants that other nodes read stay unchanged.
inline void fold_scalings(EditableGraph& graph) {
  for (std::size_t i = 0; i < graph.size(); ++i) detail::fold_scaling(graph, i);
}
}  // namespace tapestry::nn

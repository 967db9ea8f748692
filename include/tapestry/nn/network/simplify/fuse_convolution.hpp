#pragma once
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <tapestry/nn/network/simplify/editable_graph.hpp>
#include <tapestry/nn/network/simplify/merge_patterns.hpp>
#include <utility>

namespace tapestry::nn {
namespace detail {

/// A bound of Clip: an attribute up to the 10th opset, then an operand.
[[nodiscard]] inline bool read_bound(const EditableGraph& graph, const Node& clip, std::size_t which,
                                     double& to) {
  to = attribute_of(clip, which == 0 ? "min" : "max", to);
  if (graph.opset() < 11 || clip.inputs.size() <= which + 1 || clip.inputs[which + 1].empty()) return true;
  const Constant* known = graph.constant(clip.inputs[which + 1]);
  if (known == nullptr || known->size() != 1) return false;
  to = known->at(0);
  return true;
}

/// The slope of a LeakyRelu, or of a PRelu of `value` that has a single one for all channels; NaN if there is
/// none.
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

/// Adds another tensor of the same extents that is there before the convolution. \returns whether it could
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

/// Lets convolution i do what alone reads it, as far as one can.
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

/// Lets convolutions apply the activation behind them and add what is added to them.
inline void fuse_convolutions(EditableGraph& graph) {
  for (std::size_t i = 0; i < graph.size(); ++i) detail::fuse_convolution(graph, i);
}

}  // namespace tapestry::nn

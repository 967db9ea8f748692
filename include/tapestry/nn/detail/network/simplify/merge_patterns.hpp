#pragma once
#include <tapestry/nn/detail/network/operator_context.hpp>
#include <tapestry/nn/detail/network/simplify/editable_graph.hpp>

namespace tapestry::nn {
namespace detail {
/// The other operand of a node with two operands, one of them `value`.
[[nodiscard]] inline const std::string& other_operand(const Node& node, const std::string& value) {
  return node.inputs[node.inputs[0] == value ? 1 : 0];
}

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

/// Merges x · Sigmoid(x) to Swish, and x · HardSigmoid(x) with the numbers of HardSwish to HardSwish; i is
/// the inner function.
inline void merge_gate(EditableGraph& graph, std::size_t i) {
  const bool is_hard = graph.is(i, "HardSigmoid");
  if (!is_hard && !graph.is(i, "Sigmoid")) return;
  const Node inner = graph.node(i);
  const std::size_t product = graph.only_reader(inner.outputs[0]);
  if (!graph.is(product, "Mul") || other_operand(graph.node(product), inner.outputs[0]) != inner.inputs[0])
    return;
  const double alpha = attribute_of(inner, "alpha", 0.2), beta = attribute_of(inner, "beta", 0.5);
  // A sixth is rounded to single precision in files.
  if (is_hard && (std::abs(alpha - 1.0 / 6) > 1e-7 || beta != 0.5)) return;
  Node merged{graph.node(product).name,
              is_hard ? "HardSwish" : "Swish",
              {inner.inputs[0]},
              graph.node(product).outputs,
              {}};
  graph.remove(i);
  graph.replace(product, std::move(merged));
}

/// Merges x · Clip(x + 3, 0, 6) / 6, in either order of product and quotient, to HardSwish; i is the Clip.
inline void merge_hard_swish(EditableGraph& graph, std::size_t i) {
  double low = -1, high = -1;
  if (!graph.is(i, "Clip") || !read_bound(graph, graph.node(i), 0, low) ||
      !read_bound(graph, graph.node(i), 1, high) || low != 0 || high != 6)
    return;
  const auto number = [&](const std::string& value) {
    const Constant* const constant = graph.constant(value);
    const bool is_one =
        constant != nullptr && constant->size() == 1 && constant->type == ElementType::floating;
    return is_one ? constant->at(0) : 0;
  };
  const std::string &raised = graph.node(i).inputs[0], &clipped = graph.node(i).outputs[0];
  const std::size_t sum = graph.maker(raised), second = graph.only_reader(clipped);
  if (!graph.is(sum, "Add") || graph.only_reader(raised) != i || second == EditableGraph::none) return;
  const bool is_second = number(graph.node(sum).inputs[1]) == 3;
  if (!is_second && number(graph.node(sum).inputs[0]) != 3) return;
  const std::string x = graph.node(sum).inputs[is_second ? 0 : 1], between = graph.node(second).outputs[0];
  const std::size_t third = graph.only_reader(between);
  if (third == EditableGraph::none || !graph.have_same_shape(x, graph.node(third).outputs[0])) return;
  const auto multiplies = [&](const Node& node, const std::string& value) {
    return node.operation == "Mul" && other_operand(node, value) == x;
  };
  const auto divides = [&](const Node& node, const std::string& value) {  // a sixth is rounded in files
    if (node.operation == "Div") return node.inputs[0] == value && number(node.inputs[1]) == 6;
    return node.operation == "Mul" && std::abs(number(other_operand(node, value)) - 1.0 / 6) < 1e-8;
  };
  const Node &one = graph.node(second), &other = graph.node(third);
  if (!(multiplies(one, clipped) && divides(other, between)) &&
      !(divides(one, clipped) && multiplies(other, between)))
    return;
  Node merged{other.name, "HardSwish", {x}, other.outputs, {}};
  for (const std::size_t gone : {sum, i, second}) graph.remove(gone);
  graph.replace(third, std::move(merged));
}

/// Merges Reshape to [N, g, C/g, H, W], Transpose of axes 1 and 2, and Reshape back to ChannelShuffle; i is
/// the Transpose.
inline void merge_shuffle(EditableGraph& graph, std::size_t i) {
  if (!graph.is(i, "Transpose")) return;
  const Node turn = graph.node(i);
  if (attribute_of(turn, "perm", std::vector<std::int64_t>()) != std::vector<std::int64_t>{0, 2, 1, 3, 4})
    return;
  const std::size_t before = graph.maker(turn.inputs[0]), after = graph.only_reader(turn.outputs[0]);
  if (!graph.is(before, "Reshape") || !graph.is(after, "Reshape") || graph.only_reader(turn.inputs[0]) != i ||
      graph.node(after).inputs[0] != turn.outputs[0])
    return;
  const std::string in = graph.node(before).inputs[0], out = graph.node(after).outputs[0];
  const Shape *five = graph.shape(turn.inputs[0]), *four = graph.shape(in);
  if (five == nullptr || four == nullptr || four->size() != 4 || five->size() != 5) return;
  const Shape expected{(*five)[0], (*five)[1] * (*five)[2], (*five)[3], (*five)[4]};
  if (*four != expected || !graph.have_same_shape(in, out)) return;
  const auto groups = static_cast<std::int64_t>((*five)[1]);
  Node merged{turn.name, "ChannelShuffle", {in}, {out}, {{"group", groups}}};
  graph.remove(before);
  graph.remove(i);
  graph.replace(after, std::move(merged));
}

/// Zeros that a node Pad puts around rows and columns, [top, left, bottom, right]; empty if it does anything
/// else.
[[nodiscard]] inline std::vector<std::int64_t> zeros_of(const EditableGraph& graph, const Node& pad) {
  if (attribute_of(pad, "mode", std::string("constant")) != "constant") return {};
  if (pad.inputs.size() > 3 && !pad.inputs[3].empty()) return {};  // it has an operand `axes`
  if (attribute_of(pad, "value", 0.0) != 0) return {};
  if (pad.inputs.size() > 2 && !pad.inputs[2].empty()) {
    const Constant* value = graph.constant(pad.inputs[2]);
    if (value == nullptr || value->size() != 1 || value->at(0) != 0) return {};
  }
  auto pads = attribute_of(pad, "pads", std::vector<std::int64_t>());
  if (graph.opset() >= 11) {
    const Constant* known = graph.constant(pad.inputs[1]);
    if (known == nullptr) return {};
    for (std::size_t i = 0; i < known->size(); ++i) pads.push_back(OperatorContext::to_integer(known->at(i)));
  }
  const Shape* shape = graph.shape(pad.inputs[0]);
  if (pads.size() != 8 || shape == nullptr || shape->size() != 4) return {};
  const bool is_spatial = pads[0] == 0 && pads[1] == 0 && pads[4] == 0 && pads[5] == 0;
  if (!is_spatial || std::ranges::any_of(pads, [](std::int64_t count) { return count < 0; })) return {};
  return {pads[2], pads[3], pads[6], pads[7]};
}

/// Merges zeros around a picture, the Pad i, into the padding of the convolution or average pooling that is
/// its only reader.
inline void merge_pad(EditableGraph& graph, std::size_t i) {
  if (!graph.is(i, "Pad")) return;
  const Node pad = graph.node(i);
  const std::size_t reader = graph.only_reader(pad.outputs[0]);
  const bool is_convolution = graph.is(reader, "Conv");
  if (!is_convolution && !graph.is(reader, "AveragePool")) return;
  Node node = graph.node(reader);
  const std::string auto_pad = attribute_of(node, "auto_pad", std::string("NOTSET"));
  if (node.inputs[0] != pad.outputs[0] || (auto_pad != "NOTSET" && auto_pad != "VALID")) return;
  auto pads = attribute_of(node, "pads", std::vector<std::int64_t>(4, 0));
  const bool has_own = std::ranges::any_of(pads, [](std::int64_t count) { return count != 0; });
  // A pooling that ignores its own zeros would have counted the Pad's zeros.
  if (!is_convolution && ((has_own && attribute_of<std::int64_t>(node, "count_include_pad", 0) == 0) ||
                          attribute_of<std::int64_t>(node, "ceil_mode", 0) != 0))
    return;
  const auto zeros = zeros_of(graph, pad);
  if (zeros.empty() || pads.size() != 4) return;
  if (auto_pad == "VALID") pads.assign(4, 0);
  for (std::size_t k = 0; k < 4; ++k) pads[k] += zeros[k];
  node.attributes["pads"] = pads;
  node.attributes.erase("auto_pad");
  if (!is_convolution) node.attributes["count_include_pad"] = std::int64_t(1);
  node.inputs[0] = pad.inputs[0];
  graph.remove(i);
  graph.replace(reader, std::move(node));
}
}  // namespace detail

/// Removes nodes that only copy a value, casts between floating-point types included.
inline void remove_copies(EditableGraph& graph) {
  for (std::size_t i = 0; i < graph.size(); ++i) {
    const Node node = graph.node(i);
    const bool keeps_type = (node.operation == "Cast" || node.operation == "CastLike") &&
                            graph.have_same_type(node.inputs[0], node.outputs[0]);
    if (node.operation != "Identity" && node.operation != "Dropout" && !keeps_type) continue;
    const bool has_mask = node.outputs.size() > 1 &&
                          (graph.is_result(node.outputs[1]) || !graph.readers(node.outputs[1]).empty());
    if (has_mask || node.inputs.empty() || node.outputs[0].empty() || graph.is_result(node.outputs[0]))
      continue;
    graph.redirect(node.outputs[0], node.inputs[0]);
    graph.remove(i);
  }
}

/// Replaces groups of nodes that stand for one operation by that operation.
inline void merge_patterns(EditableGraph& graph) {
  for (std::size_t i = 0; i < graph.size(); ++i) {
    detail::merge_gate(graph, i);
    detail::merge_hard_swish(graph, i);
    detail::merge_shuffle(graph, i);
    detail::merge_pad(graph, i);
  }
}
}  // namespace tapestry::nn

#pragma once
#include <tapestry/nn/detail/network/tangent_network.hpp>

/// \file
/// Rules of tangent_network(), by operator. Each writes a node and the tangents of its results.

namespace tapestry::nn::detail {
using TangentRule = void (*)(TangentParts&);

inline void take_over(TangentParts& parts) {
  parts.keep();
  parts.set(parts.tangent(0));
}

/// Of operators that are linear in operand 0, with nothing added.
inline void apply_to_first(TangentParts& parts) {
  auto inputs = parts.node().inputs;
  for (std::size_t i = 1; i < inputs.size(); ++i)
    if (parts.varies(i)) parts.refuse();
  inputs[0] = parts.tangent(0);
  parts.keep();
  parts.set(parts.same(std::move(inputs)));
}

/// Of operators that are linear in all their numbers together.
inline void apply_to_all(TangentParts& parts) {
  auto inputs = parts.node().inputs;
  for (std::string& input : inputs)
    if (!input.empty() && parts.is_number(input)) input = parts.tangent(input);
  parts.keep();
  parts.set(parts.same(std::move(inputs)));
}

inline void scatter(TangentParts& parts) {
  const auto rule = attribute_of(parts.node(), "reduction", std::string("none"));
  rule == "none" || rule == "add" ? apply_to_all(parts) : parts.refuse();
}

/// Pad and Resize, whose value outside of x is 0 in the tangent.
inline void surround(TangentParts& parts) {
  Node node = parts.node();
  node.inputs[0] = parts.tangent(0);
  if (node.operation == "Pad" && parts.opset() >= 11 && node.inputs.size() > 2) node.inputs[2].clear();
  for (const char* const attribute : {"value", "extrapolation_value"}) node.attributes.erase(attribute);
  parts.keep();
  parts.set(parts.add_all(node.operation, node.inputs, node.attributes, {""}));
}

inline void align_regions(TangentParts& parts) {
  const bool is_mean = attribute_of(parts.node(), "mode", std::string("avg")) == "avg";
  is_mean ? apply_to_first(parts) : parts.refuse();
}

inline void sum(TangentParts& parts) {
  parts.keep();
  if (parts.varies(0) && parts.varies(1)) return parts.set(parts.same({parts.tangent(0), parts.tangent(1)}));
  const std::size_t i = parts.varies(0) ? 0 : 1;
  const bool turns = i == 1 && parts.node().operation == "Sub";
  const std::string tangent = turns ? parts.add("Neg", {parts.tangent(i)}) : parts.tangent(i);
  parts.set(parts.expanded(tangent, parts.shape(parts.input(i))));
}

/// Of a node that is linear in operands 0 and `second` apart, with operands that are added.
/// \param like  the node, with the operands and attributes of its tangents
inline void product_of(TangentParts& parts, const Node& like, std::size_t second,
                       std::initializer_list<std::size_t> added) {
  parts.keep();
  std::string sum;
  const bool has_one = parts.varies(0) || parts.varies(second);
  for (const std::size_t i : {std::size_t(0), second}) {
    if (!parts.varies(i) && (has_one || i != 0)) continue;
    auto inputs = like.inputs;
    inputs[i] = parts.tangent(i);
    for (const std::size_t k : added)
      if (k < inputs.size()) inputs[k] = sum.empty() && parts.varies(k) ? parts.tangent(k) : "";
    const std::string term = parts.add_all(like.operation, inputs, like.attributes, {""}).front();
    sum = sum.empty() ? term : parts.add("Add", {sum, term});
  }
  parts.set(sum);
}
inline void product(TangentParts& parts) { product_of(parts, parts.node(), 1, {2}); }

/// FusedConv without an activation, or with a rectifier, whose tangent takes the signs of the result.
inline void fused_convolution(TangentParts& parts) {
  Node node = parts.node();
  if (node.attributes.contains("signs")) parts.refuse();
  const std::string name = attribute_of(node, "activation", std::string());
  if (name.empty()) return product_of(parts, node, 2, {1, 3});
  node.attributes["signs"] = name == "Relu" ? 0.0 : attribute_of(node, "activation_a", 0.0);
  for (const char* const attribute : {"activation", "activation_a", "activation_b", "adds_first"})
    node.attributes.erase(attribute);
  node.inputs[1] = parts.result();
  product_of(parts, node, 2, {3});
}

/// A function of each element or a choice of elements.
inline void function(TangentParts& parts) {
  Node node = parts.node();
  node.inputs.insert(node.inputs.begin() + 1, parts.tangent(0));
  node.attributes["of"] = node.operation;
  const bool is_pool = node.operation == "MaxPool" || node.operation == "GlobalMaxPool";
  const auto both =
      parts.add_all(is_pool ? "TangentPool" : "Tangent", node.inputs, node.attributes, {parts.result(), ""});
  parts.set(both[1]);
}

/// ẏ = b·a^(b − 1)·ȧ, 0 for b = 0.
inline void power(TangentParts& parts) {
  if (parts.varies(1)) parts.refuse();
  const std::string zero = parts.number(0), one = parts.number(1);
  const std::string exponent = parts.add("Cast", {parts.input(1)}, {{"to", std::int64_t(1)}});
  const std::string less =
      parts.add("Where", {parts.add("Equal", {exponent, zero}), one, parts.add("Sub", {exponent, one})});
  const std::string slope = parts.add("Mul", {exponent, parts.add("Pow", {parts.input(0), less})});
  parts.keep();
  parts.set(parts.add("Mul", {slope, parts.tangent(0)}));
}

/// The tangent of the first operand that equals the result.
inline void extreme(TangentParts& parts) {
  parts.keep();
  const std::size_t last = parts.node().inputs.size() - 1;
  std::string tangent = parts.expanded(parts.tangent(last), parts.shape(parts.input(last)));
  for (std::size_t i = last; i-- > 0;) {
    const std::string is_it = parts.add("Equal", {parts.input(i), parts.result()});
    tangent = parts.add("Where", {is_it, parts.tangent(i), tangent});
  }
  parts.set(tangent);
}

inline void softmax(TangentParts& parts) {
  parts.keep();
  const auto rank = static_cast<std::int64_t>(parts.shape(parts.input(0)).size());
  const bool has_one = parts.opset() >= 13, is_log = parts.node().operation == "LogSoftmax";
  const std::int64_t axis = attribute_of<std::int64_t>(parts.node(), "axis", has_one ? -1 : 1);
  std::vector<std::int64_t> axes{axis < 0 ? axis + rank : axis};
  while (!has_one && axes.back() + 1 < rank) axes.push_back(axes.back() + 1);
  const std::string shares = is_log ? parts.add("Exp", {parts.result()}) : parts.result();
  const std::string mean = parts.reduced("ReduceSum", parts.add("Mul", {shares, parts.tangent(0)}), axes);
  const std::string apart = parts.add("Sub", {parts.tangent(0), mean});
  parts.set(is_log ? apart : parts.add("Mul", {shares, apart}));
}

inline void top(TangentParts& parts) {
  auto outputs = parts.node().outputs;
  outputs.resize(2);
  outputs = parts.add_all("TopK", parts.node().inputs, parts.node().attributes, std::move(outputs));
  const std::int64_t axis = attribute_of<std::int64_t>(parts.node(), "axis", -1);
  parts.set(parts.add("GatherElements", {parts.tangent(0), outputs[1]}, {{"axis", axis}}));
}

/// Reductions that are not linear. The tangent of a product with a 0 is not a number.
inline void reduction(TangentParts& parts) {
  parts.keep();
  const std::string& name = parts.node().operation;
  const std::string &x = parts.input(0), &y = parts.result(), tangent = parts.tangent(0);
  const auto sum_of = [&](const std::string& value) {
    const bool keeps = attribute_of<std::int64_t>(parts.node(), "keepdims", 1) != 0;
    return parts.reduced("ReduceSum", value, parts.axes(), keeps);
  };
  if (name == "ReduceL1") return parts.set(sum_of(parts.add("Mul", {parts.add("Sign", {x}), tangent})));
  if (name == "ReduceSumSquare")
    return parts.set(parts.add("Mul", {parts.number(2), sum_of(parts.add("Mul", {x, tangent}))}));
  if (name == "ReduceL2") {  // 0 where the norm is
    const std::string is_zero = parts.add("Equal", {y, parts.number(0)});
    const std::string norm = parts.add("Where", {is_zero, parts.number(1), y});
    return parts.set(parts.add("Div", {sum_of(parts.add("Mul", {x, tangent})), norm}));
  }
  if (name == "ReduceLogSum") return parts.set(parts.add("Div", {sum_of(tangent), sum_of(x)}));
  if (name == "ReduceProd") return parts.set(parts.add("Mul", {y, sum_of(parts.add("Div", {tangent, x}))}));
  const std::string whole = parts.reduced("ReduceLogSumExp", x, parts.axes());
  const std::string shares = parts.add("Exp", {parts.add("Sub", {x, whole})});
  parts.set(sum_of(parts.add("Mul", {shares, tangent})));
}

/// The rule of an operator; null if there is none.
[[nodiscard]] inline TangentRule tangent_rule(std::string_view operation) {
  static const std::vector<std::pair<TangentRule, std::set<std::string_view>>> rules{
      {take_over, {"Cast", "CastLike", "Dropout", "Identity", "StraightRound"}},
      {apply_to_first, {"AveragePool", "ChannelShuffle",    "CumSum",        "DepthToSpace", "Div",
                        "Expand",      "Flatten",           "FlattenPixels", "Gather",       "GatherElements",
                        "GatherND",    "GlobalAveragePool", "GridSample",    "Neg",          "PixelUnshuffle",
                        "ReduceMean",  "ReduceSum",         "Reshape",       "Slice",        "SpaceToDepth",
                        "Split",       "Squeeze",           "Tile",          "Transpose",    "Trilu",
                        "Unsqueeze",   "Upsample"}},
      {apply_to_all, {"Concat", "InterleaveChannels", "Mean", "Sum", "Where"}},
      {scatter, {"Scatter", "ScatterElements", "ScatterND"}},
      {surround, {"Pad", "Resize"}},
      {align_regions, {"RoiAlign"}},
      {sum, {"Add", "Sub"}},
      {product, {"Conv", "ConvTranspose", "Gemm", "MatMul", "Mul"}},
      {fused_convolution, {"FusedConv"}},
      {power, {"Pow"}},
      {extreme, {"Max", "Min"}},
      {softmax, {"LogSoftmax", "Softmax"}},
      {top, {"TopK"}},
      {reduction,
       {"ReduceL1", "ReduceL2", "ReduceLogSum", "ReduceLogSumExp", "ReduceProd", "ReduceSumSquare"}},
      {function,
       {"Abs",     "Acos",          "Acosh",      "Asin",           "Asinh",     "Atan",      "Atanh",
        "Celu",    "Clip",          "Cos",        "Cosh",           "Elu",       "Erf",       "Exp",
        "Gelu",    "GlobalMaxPool", "HardMish",   "HardSigmoid",    "HardSwish", "LeakyRelu", "Log",
        "MaxPool", "Mish",          "Reciprocal", "ReduceMax",      "ReduceMin", "Relu",      "Selu",
        "Shrink",  "Sigmoid",       "Sin",        "Sinh",           "Softplus",  "Softsign",  "Sqrt",
        "Swish",   "Tan",           "Tanh",       "ThresholdedRelu"}}};
  for (const auto& [rule, names] : rules)
    if (names.contains(operation)) return rule;
  return nullptr;
}
}  // namespace tapestry::nn::detail

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
  for (std::size_t i = 1; i < parts.node().inputs.size(); ++i)
    if (parts.varies(i)) parts.refuse();
  parts.keep();
  auto inputs = parts.node().inputs;
  inputs[0] = parts.tangent(0);
  const auto results = parts.same(std::move(inputs));
  for (std::size_t i = 0; i < results.size(); ++i) parts.set(results[i], i);
}

/// Of operators that are linear in all their numbers together.
inline void apply_to_all(TangentParts& parts) {
  parts.keep();
  auto inputs = parts.node().inputs;
  for (std::string& input : inputs)
    if (!input.empty() && parts.is_number(input)) input = parts.tangent(input);
  const auto results = parts.same(std::move(inputs));
  for (std::size_t i = 0; i < results.size(); ++i) parts.set(results[i], i);
}

inline void scatter(TangentParts& parts) {
  const auto rule = attribute_of(parts.node(), "reduction", std::string("none"));
  if (rule != "none" && rule != "add") parts.refuse();
  apply_to_all(parts);
}

inline void without_value(TangentParts& parts, const char* attribute, std::size_t operand) {
  parts.keep();
  auto inputs = parts.node().inputs;
  auto attributes = parts.node().attributes;
  inputs[0] = parts.tangent(0);
  if (operand < inputs.size()) inputs[operand].clear();
  attributes.erase(attribute);
  parts.set(parts.add_all(parts.node().operation, std::move(inputs), std::move(attributes), {""}).front());
}
inline void pad(TangentParts& parts) { without_value(parts, "value", parts.opset() >= 11 ? 2 : 9); }
inline void resize(TangentParts& parts) { without_value(parts, "extrapolation_value", 9); }

inline void align_regions(TangentParts& parts) {
  if (attribute_of(parts.node(), "mode", std::string("avg")) != "avg") parts.refuse();
  apply_to_first(parts);
}

inline void normalize_batch(TangentParts& parts) {
  auto inputs = parts.node().inputs;
  for (std::size_t i = 1; i < inputs.size(); ++i)
    if (parts.varies(i)) parts.refuse();
  if (attribute_of<std::int64_t>(parts.node(), "training_mode", 0) != 0) parts.refuse();
  parts.keep();
  inputs[0] = parts.tangent(0);
  inputs[2] = inputs[3] = parts.zeros(parts.shape(inputs[3]));
  parts.set(parts.same(std::move(inputs)).front());
}

inline void sum(TangentParts& parts) {
  parts.keep();
  if (parts.varies(0) && parts.varies(1))
    return parts.set(parts.same({parts.tangent(0), parts.tangent(1)}).front());
  const std::size_t i = parts.varies(0) ? 0 : 1;
  const bool turns = i == 1 && parts.node().operation == "Sub";
  const std::string tangent = turns ? parts.add("Neg", {parts.tangent(i)}) : parts.tangent(i);
  parts.set(parts.expanded(tangent, parts.shape(parts.input(i))));
}

/// The tangent of a node that is linear in operands 0 and `second` apart, with operands that are added.
inline std::string tangent_of_product(TangentParts& parts, const Node& node, std::size_t second,
                                      const std::vector<std::size_t>& added = {}) {
  std::string sum;
  const bool has_one = parts.varies(node.inputs[0]) || parts.varies(node.inputs[second]);
  for (const std::size_t i : {std::size_t(0), second}) {
    if (!parts.varies(node.inputs[i]) && (has_one || i != 0)) continue;
    auto inputs = node.inputs;
    inputs[i] = parts.tangent(inputs[i]);
    for (const std::size_t k : added)
      if (k < inputs.size() && !inputs[k].empty())
        inputs[k] = sum.empty() && parts.varies(inputs[k]) ? parts.tangent(inputs[k]) : "";
    const std::string term = parts.add_all(node.operation, std::move(inputs), node.attributes, {""}).front();
    sum = sum.empty() ? term : parts.add("Add", {sum, term});
  }
  return sum;
}
inline void product(TangentParts& parts) {
  parts.keep();
  parts.set(tangent_of_product(parts, parts.node(), 1, {2}));
}

/// The node that applies `of` to x, and its tangent.
inline Decomposer::Names function_and_tangent(TangentParts& parts, const std::string& of, Decomposer::Names x,
                                              Decomposer::Attributes attributes, const std::string& result) {
  attributes["of"] = of;
  const bool is_pool = of == "MaxPool" || of == "GlobalMaxPool";
  return parts.add_all(is_pool ? "TangentPool" : "Tangent", std::move(x), std::move(attributes),
                       {result, ""});
}
inline void function(TangentParts& parts) {
  auto inputs = parts.node().inputs;
  inputs.insert(inputs.begin() + 1, parts.tangent(0));
  const auto results = function_and_tangent(parts, parts.node().operation, std::move(inputs),
                                            parts.node().attributes, parts.result());
  parts.set(results[1]);
}

/// FusedConv. A rectifier's tangent takes the signs of the result, other activations are applied behind the
/// convolution, which then gives its sums.
inline void fused_convolution(TangentParts& parts) {
  const Node& node = parts.node();
  const std::string name = attribute_of(node, "activation", std::string());
  const double a = attribute_of(node, "activation_a", 0.0), b = attribute_of(node, "activation_b", 0.0);
  const bool has_addend = !node.inputs[1].empty();
  const bool adds_first = attribute_of<std::int64_t>(node, "adds_first", 0) != 0;
  if (node.attributes.contains("signs")) parts.refuse();
  if (name.empty()) {
    parts.keep();
    return parts.set(tangent_of_product(parts, node, 2, {1, 3}));
  }
  Node inner = node;
  for (const char* attribute : {"activation", "activation_a", "activation_b", "adds_first"})
    inner.attributes.erase(attribute);
  const bool is_rectifier = name == "Relu" || name == "LeakyRelu";
  if (is_rectifier && !has_addend && parts.varies(0) && !parts.varies(2) && !parts.varies(3)) {
    parts.keep();
    inner.attributes["signs"] = name == "Relu" ? 0.0 : a;
    return parts.set(parts
                         .add_all("FusedConv", {parts.tangent(0), parts.result(), node.inputs[2]},
                                  std::move(inner.attributes), {""})
                         .front());
  }
  if (!adds_first) inner.inputs[1].clear();
  const std::string sums = parts.add("FusedConv", inner.inputs, inner.attributes);
  Decomposer::Names operands{sums, tangent_of_product(parts, inner, 2, {1, 3})};
  Decomposer::Attributes attributes;
  if (name == "LeakyRelu" || name == "HardSigmoid") attributes["alpha"] = a;
  if (name == "HardSigmoid") attributes["beta"] = b;
  if (name == "Clip" && parts.opset() >= 11)
    operands.insert(operands.end(), {parts.number(a), parts.number(b)});
  if (name == "Clip" && parts.opset() < 11) attributes = {{"min", a}, {"max", b}};
  const bool adds_last = has_addend && !adds_first;
  const auto both = function_and_tangent(parts, name, std::move(operands), std::move(attributes),
                                         adds_last ? "" : parts.result());
  if (!adds_last) return parts.set(both[1]);
  parts.finish(0, "Add", {both[0], node.inputs[1]});
  parts.set(parts.varies(1) ? parts.add("Add", {both[1], parts.tangent(1)}) : both[1]);
}

inline void quotient(TangentParts& parts) {
  parts.keep();
  std::string change = parts.varies(0) ? parts.tangent(0) : "";
  if (parts.varies(1)) {
    const std::string term = parts.add("Mul", {parts.result(), parts.tangent(1)});
    change = change.empty() ? parts.add("Neg", {term}) : parts.add("Sub", {change, term});
  }
  parts.set(parts.add("Div", {change, parts.input(1)}));
}

inline void power(TangentParts& parts) {
  parts.keep();
  const std::string &base = parts.input(0), zero = parts.number(0), one = parts.number(1);
  const std::string exponent = parts.add("Cast", {parts.input(1)}, {{"to", std::int64_t(1)}});
  std::string sum;
  if (parts.varies(0)) {  // b·a^(b − 1), 0 for b = 0
    const std::string less =
        parts.add("Where", {parts.add("Equal", {exponent, zero}), one, parts.add("Sub", {exponent, one})});
    const std::string slope = parts.add("Mul", {exponent, parts.add("Pow", {base, less})});
    sum = parts.add("Mul", {slope, parts.tangent(0)});
  }
  if (parts.varies(1)) {  // a^b·log a, 0 unless a is above 0
    const std::string above = parts.add("Greater", {base, zero});
    const std::string logarithm = parts.add("Log", {parts.add("Where", {above, base, one})});
    const std::string term =
        parts.add("Mul", {parts.add("Mul", {parts.result(), logarithm}), parts.tangent(1)});
    sum = sum.empty() ? term : parts.add("Add", {sum, term});
  }
  parts.set(sum);
}

/// a − b · (a/b without its fraction).
inline void remainder(TangentParts& parts) {
  parts.keep();
  std::string tangent = parts.expanded(parts.tangent(0), parts.shape(parts.input(0)));
  if (parts.varies(1)) {
    const std::string whole =
        parts.add("Cast", {parts.add("Div", {parts.input(0), parts.input(1)})}, {{"to", std::int64_t(7)}});
    const std::string count = parts.add("Cast", {whole}, {{"to", std::int64_t(1)}});
    tangent = parts.add("Sub", {tangent, parts.add("Mul", {count, parts.tangent(1)})});
  }
  parts.set(tangent);
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

inline void rectify_by_weight(TangentParts& parts) {
  parts.keep();
  const std::string above = parts.add("Greater", {parts.input(0), parts.number(0)});
  std::string sum;
  if (parts.varies(0)) {
    const std::string slope = parts.add("Where", {above, parts.number(1), parts.input(1)});
    sum = parts.add("Mul", {slope, parts.tangent(0)});
  }
  if (parts.varies(1)) {
    const std::string below = parts.add("Where", {above, parts.number(0), parts.input(0)});
    const std::string term = parts.add("Mul", {below, parts.tangent(1)});
    sum = sum.empty() ? term : parts.add("Add", {sum, term});
  }
  parts.set(sum);
}

inline void softmax(TangentParts& parts) {
  parts.keep();
  const auto rank = static_cast<std::int64_t>(parts.shape(parts.input(0)).size());
  const bool has_one = parts.opset() >= 13, is_log = parts.node().operation == "LogSoftmax";
  std::int64_t axis = attribute_of<std::int64_t>(parts.node(), "axis", has_one ? -1 : 1);
  if (axis < 0) axis += rank;
  std::vector<std::int64_t> axes{axis};
  for (std::int64_t next = axis + 1; !has_one && next < rank; ++next) axes.push_back(next);
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

/// ReduceL2, ReduceSumSquare, ReduceLogSum, ReduceLogSumExp and ReduceProd. That of a product with a 0 is not
/// a number.
inline void reduction(TangentParts& parts) {
  parts.keep();
  const std::string& name = parts.node().operation;
  const std::string &x = parts.input(0), &y = parts.result(), tangent = parts.tangent(0);
  const bool keeps = attribute_of<std::int64_t>(parts.node(), "keepdims", 1) != 0;
  const auto sum_of = [&](const std::string& value) {
    return parts.reduced("ReduceSum", value, parts.axes(), keeps);
  };
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

/// The rules, by the operators' names.
[[nodiscard]] inline const std::map<std::string, TangentRule, std::less<>>& tangent_rules() {
  static const auto table = [] {
    std::map<std::string, TangentRule, std::less<>> all{{"Pad", pad},
                                                        {"Resize", resize},
                                                        {"RoiAlign", align_regions},
                                                        {"Add", sum},
                                                        {"Sub", sum},
                                                        {"FusedConv", fused_convolution},
                                                        {"Div", quotient},
                                                        {"Pow", power},
                                                        {"Mod", remainder},
                                                        {"Max", extreme},
                                                        {"Min", extreme},
                                                        {"PRelu", rectify_by_weight},
                                                        {"TopK", top},
                                                        {"Softmax", softmax},
                                                        {"LogSoftmax", softmax},
                                                        {"Where", apply_to_all},
                                                        {"BatchNormalization", normalize_batch}};
    const auto add = [&](TangentRule rule, std::initializer_list<const char*> names) {
      for (const char* const name : names) all[name] = rule;
    };
    add(take_over, {"Cast", "CastLike", "Dropout", "Identity", "StraightRound"});
    add(apply_to_first, {"AveragePool",       "ChannelShuffle", "CumSum",    "DepthToSpace",   "Expand",
                         "Flatten",           "FlattenPixels",  "Gather",    "GatherElements", "GatherND",
                         "GlobalAveragePool", "GridSample",     "Neg",       "PixelUnshuffle", "ReduceMean",
                         "ReduceSum",         "Reshape",        "Slice",     "SpaceToDepth",   "Split",
                         "Squeeze",           "Tile",           "Transpose", "Trilu",          "Unsqueeze",
                         "Upsample"});
    add(apply_to_all, {"Concat", "InterleaveChannels", "Mean", "Sum"});
    add(scatter, {"Scatter", "ScatterElements", "ScatterND"});
    add(product, {"Conv", "ConvTranspose", "Gemm", "MatMul", "Mul"});
    add(reduction, {"ReduceL2", "ReduceLogSum", "ReduceLogSumExp", "ReduceProd", "ReduceSumSquare"});
    add(function,
        {"Abs",     "Acos",          "Acosh",     "Asin",           "Asinh",      "Atan",      "Atanh",
         "Celu",    "Clip",          "Cos",       "Cosh",           "Elu",        "Erf",       "Exp",
         "Gelu",    "GlobalMaxPool", "HardMish",  "HardSigmoid",    "HardSwish",  "LeakyRelu", "Log",
         "MaxPool", "Mish",          "ReduceMax", "ReduceMin",      "Reciprocal", "Relu",      "Selu",
         "Shrink",  "Sigmoid",       "Sin",       "Sinh",           "Softplus",   "Softsign",  "Sqrt",
         "Swish",   "Tan",           "Tanh",      "ThresholdedRelu"});
    return all;
  }();
  return table;
}

}  // namespace tapestry::nn::detail

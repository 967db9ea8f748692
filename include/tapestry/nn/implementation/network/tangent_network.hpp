#pragma once
#include <tapestry/nn/implementation/network/tangent_rules.hpp>

namespace tapestry::nn {
std::vector<std::int64_t> TangentParts::axes() const {
  auto axes = attribute_of(node(), "axes", std::vector<std::int64_t>());
  if (node().inputs.size() > 1 && !input(1).empty()) {
    const Constant& given = *facts_.at(input(1)).constant;
    for (std::size_t i = 0; i < given.size(); ++i) axes.push_back(OperatorContext::to_integer(given.at(i)));
  }
  if (!axes.empty()) return axes;
  axes.resize(shape(input(0)).size());
  std::iota(axes.begin(), axes.end(), std::int64_t(0));
  return axes;
}

namespace detail {
/// x / √(variance + ε), where x has the mean 0.
[[nodiscard]] inline std::string scaled_by(TangentParts& parts, const std::string& x,
                                           const std::string& variance) {
  const std::string epsilon = parts.number(attribute_of(parts.node(), "epsilon", 1e-5));
  const std::string root = parts.add("Sqrt", {parts.add("Add", {variance, epsilon})});
  return parts.add("Mul", {x, parts.add("Reciprocal", {root})});
}
/// (x − mean) / √(variance + ε) along some axes.
[[nodiscard]] inline std::string normalised(TangentParts& parts, const std::string& x,
                                            const std::vector<std::int64_t>& axes) {
  const std::string off = parts.add("Sub", {x, parts.reduced("ReduceMean", x, axes)});
  return scaled_by(parts, off, parts.reduced("ReduceMean", parts.add("Mul", {off, off}), axes));
}
/// Operand i, a value for each channel or each group of channels, along axis 1 of operand 0.
[[nodiscard]] inline std::string along_channels(TangentParts& parts, std::size_t i) {
  const Shape& x = parts.shape(parts.input(0));
  const std::size_t count = parts.shape(parts.input(i))[0];
  std::string value = parts.input(i);
  if (count != x[1]) {
    const auto groups = static_cast<std::int64_t>(count), all = static_cast<std::int64_t>(x[1]);
    value = parts.add("Expand", {parts.reshaped(value, {count, 1}), parts.integers({groups, all / groups})});
  }
  Shape map(x.size() - 1, 1);
  map[0] = x[1];
  return parts.reshaped(value, map);
}

inline void divide_batch_normalization(TangentParts& parts) {
  if (attribute_of<std::int64_t>(parts.node(), "training_mode", 0) != 0) parts.refuse();
  const std::string off = parts.add("Sub", {parts.input(0), along_channels(parts, 3)});
  const std::string factor = scaled_by(parts, along_channels(parts, 1), along_channels(parts, 4));
  parts.finish(0, "Add", {parts.add("Mul", {off, factor}), along_channels(parts, 2)});
}

inline void divide_layer_normalization(TangentParts& parts) {
  const auto rank = static_cast<std::int64_t>(parts.shape(parts.input(0)).size());
  const std::int64_t axis = attribute_of<std::int64_t>(parts.node(), "axis", -1);
  std::vector<std::int64_t> axes;
  for (std::int64_t a = axis < 0 ? axis + rank : axis; a < rank; ++a) axes.push_back(a);
  const std::string normal = normalised(parts, parts.input(0), axes);
  if (parts.node().inputs.size() < 3) return parts.finish(0, "Mul", {normal, parts.input(1)});
  parts.finish(0, "Add", {parts.add("Mul", {normal, parts.input(1)}), parts.input(2)});
}

inline void divide_group_normalization(TangentParts& parts) {
  const Shape x = parts.shape(parts.input(0));
  const auto groups =
      static_cast<std::size_t>(attribute_of(parts.node(), "num_groups", static_cast<std::int64_t>(x[1])));
  const std::string rows = parts.reshaped(parts.input(0), {x[0], groups, size_of(x) / (x[0] * groups)});
  const std::string normal = parts.reshaped(normalised(parts, rows, {2}), x);
  parts.finish(0, "Add", {parts.add("Mul", {normal, along_channels(parts, 1)}), along_channels(parts, 2)});
}

/// x · (bias + α · (mean of x² over `size` neighbouring channels))^−β.
inline void divide_local_normalization(TangentParts& parts) {
  const Node& node = parts.node();
  const std::string& x = parts.input(0);
  const Shape shape = parts.shape(x);
  const std::int64_t size = attribute_of<std::int64_t>(node, "size", 1);
  const std::string columns = parts.reshaped(parts.add("Mul", {x, x}),
                                             {shape[0], 1, shape[1], size_of(shape) / (shape[0] * shape[1])});
  const std::string mean = parts.add("AveragePool", {columns},
                                     {{"kernel_shape", std::vector<std::int64_t>{size, 1}},
                                      {"pads", std::vector<std::int64_t>{(size - 1) / 2, 0, size / 2, 0}},
                                      {"count_include_pad", std::int64_t(1)}});
  const std::string scaled = parts.add("Mul", {mean, parts.number(attribute_of(node, "alpha", 1e-4))});
  const std::string sum = parts.add("Add", {scaled, parts.number(attribute_of(node, "bias", 1.0))});
  const std::string power = parts.add("Pow", {sum, parts.number(-attribute_of(node, "beta", 0.75))});
  parts.finish(0, "Mul", {x, parts.reshaped(power, shape)});
}

inline void divide_quotient(TangentParts& parts) {
  if (!parts.is_number(parts.input(1))) return parts.keep();
  parts.finish(0, "Mul", {parts.input(0), parts.add("Reciprocal", {parts.input(1)})});
}

inline void divide_rectifier(TangentParts& parts) {
  const std::string &x = parts.input(0), above = parts.add("Greater", {x, parts.number(0)});
  parts.finish(0, "Where", {above, x, parts.add("Mul", {x, parts.input(1)})});
}

/// FusedConv as a convolution, an activation and an addition; a rectifier without an addition stays.
inline void divide_convolution(TangentParts& parts) {
  Node node = parts.node();
  const std::string name = attribute_of(node, "activation", std::string()), addend = node.inputs[1];
  const double a = attribute_of(node, "activation_a", 0.0), b = attribute_of(node, "activation_b", 0.0);
  const bool adds_last = !addend.empty() && attribute_of<std::int64_t>(node, "adds_first", 0) == 0;
  const bool is_rectifier = name == "Relu" || name == "LeakyRelu";
  if (name.empty() || (is_rectifier && addend.empty())) return parts.keep();
  for (const char* attribute : {"activation", "activation_a", "activation_b", "adds_first"})
    node.attributes.erase(attribute);
  if (adds_last) node.inputs[1].clear();
  Decomposer::Names operands{parts.add("FusedConv", node.inputs, node.attributes)};
  Decomposer::Attributes attributes;
  if (name == "LeakyRelu" || name == "HardSigmoid") attributes["alpha"] = a;
  if (name == "HardSigmoid") attributes["beta"] = b;
  if (name == "Clip" && parts.opset() < 11) attributes = {{"min", a}, {"max", b}};
  if (name == "Clip" && parts.opset() >= 11) operands = {operands[0], parts.number(a), parts.number(b)};
  if (!adds_last) return parts.finish(0, name.c_str(), operands, attributes);
  parts.finish(0, "Add", {parts.add(name.c_str(), operands, attributes), addend});
}

/// Writes each node again, by rule_of(node) or, where that is null, unchanged.
template <class RuleOf>
void rewrite(NetworkDescription& description, const NetworkFacts& facts, ValueNames& names,
             std::map<std::string, std::string>& tangents, const RuleOf& rule_of) {
  PlanBudget budget;
  budget.nodes = PlanBudget().planned;
  std::vector<Node> nodes;
  for (Node& node : description.nodes) {
    const TangentRule rule = rule_of(node);
    if (rule == nullptr) {
      nodes.push_back(std::move(node));
      continue;
    }
    TangentParts parts(node, description.opset, names, budget, facts, tangents);
    rule(parts);
    Decomposition written = parts.take();
    std::ranges::move(written.nodes, std::back_inserter(nodes));
    description.constants.merge(written.constants);
  }
  description.nodes = std::move(nodes);
}

/// Names of a description's values.
[[nodiscard]] inline ValueNames names_of(const NetworkDescription& description) {
  ValueNames names;
  for (const InputDescription& input : description.inputs) names.taken.insert(input.name);
  for (const auto& [name, constant] : description.constants) names.taken.insert(name);
  for (const Node& node : description.nodes) names.taken.insert(node.outputs.begin(), node.outputs.end());
  return names;
}
}  // namespace detail

NetworkDescription divided_for_tangents(NetworkDescription description, const NetworkFacts& facts) {
  static const std::map<std::string_view, detail::TangentRule> rules{
      {"BatchNormalization", detail::divide_batch_normalization},
      {"Div", detail::divide_quotient},
      {"FusedConv", detail::divide_convolution},
      {"GroupNormalization", detail::divide_group_normalization},
      {"InstanceNormalization", detail::divide_group_normalization},
      {"LRN", detail::divide_local_normalization},
      {"LayerNormalization", detail::divide_layer_normalization},
      {"PRelu", detail::divide_rectifier}};
  ValueNames names = detail::names_of(description);
  std::map<std::string, std::string> none;
  detail::rewrite(description, facts, names, none, [&](const Node& node) -> detail::TangentRule {
    const auto found = rules.find(node.operation);
    return found == rules.end() || facts.at(node.outputs.front()).constant != nullptr ? nullptr
                                                                                      : found->second;
  });
  return description;
}

NetworkDescription tangent_network(NetworkDescription description, const NetworkFacts& facts,
                                   const std::set<std::string>& weights) {
  static const std::set<std::string_view> steps{"Ceil",   "ConstantOfShape", "EyeLike", "Floor", "Hardmax",
                                                "OneHot", "Range",           "Round",   "Sign"};
  ValueNames names = detail::names_of(description);
  std::map<std::string, std::string> tangents;
  const std::vector<InputDescription> inputs = description.inputs;
  for (const InputDescription& input : inputs) {
    if (input.type != ElementType::floating) continue;
    const Shape& shape = facts.at(input.name).shape;
    tangents[input.name] = names.next(input.name);
    description.inputs.push_back({tangents[input.name], {shape.begin(), shape.end()}});
  }
  for (const std::string& weight : weights) {
    Constant& twin = description.constants[tangents[weight] = names.next(weight)];
    twin = {facts.at(weight).constant->shape, ElementType::floating, {}};
    twin.values = std::vector<float>(size_of(twin.shape));
  }
  detail::rewrite(description, facts, names, tangents, [&](const Node& node) -> detail::TangentRule {
    const bool varies = std::ranges::any_of(node.inputs, [&](auto& name) { return tangents.contains(name); });
    const bool is_smooth = std::ranges::any_of(node.outputs, [&](const std::string& name) {
      return !name.empty() && facts.at(name).type == ElementType::floating;
    });
    if (!varies || !is_smooth || steps.contains(node.operation)) return nullptr;
    const auto rule = detail::tangent_rule(node.operation);
    return rule != nullptr ? rule : [](TangentParts& parts) { parts.refuse(); };
  });
  auto outputs = description.outputs;
  for (const std::string& output : description.outputs) {
    const auto found = tangents.find(output);
    outputs.push_back(found != tangents.end() ? found->second : names.next(output));
    if (found != tangents.end()) continue;
    const ValueFacts& own = facts.at(output);
    const Shape& shape = own.constant != nullptr ? own.constant->shape : own.shape;
    description.constants[outputs.back()] = {shape, ElementType::floating,
                                             std::vector<double>(size_of(shape))};
  }
  return pruned(std::move(description), std::move(outputs));
}
}  // namespace tapestry::nn

#pragma once
#include <tapestry/nn/implementation/network/tangent_rules.hpp>

namespace tapestry::nn {

std::vector<std::int64_t> TangentParts::axes() const {
  auto axes = attribute_of(node(), "axes", std::vector<std::int64_t>());
  if (node().inputs.size() > 1 && !input(1).empty()) {
    const Constant& given = *facts_of(input(1)).constant;
    for (std::size_t i = 0; i < given.size(); ++i) axes.push_back(OperatorContext::to_integer(given.at(i)));
  }
  if (!axes.empty() || attribute_of<std::int64_t>(node(), "noop_with_empty_axes", 0) != 0) return axes;
  axes.resize(shape(input(0)).size());
  std::iota(axes.begin(), axes.end(), std::int64_t(0));
  return axes;
}

namespace detail {

/// (x − mean) / √(variance + ε) along some axes.
[[nodiscard]] inline std::string normalised(Decomposer& parts, const std::string& x,
                                            const std::vector<std::int64_t>& axes, double epsilon) {
  const std::string off = parts.add("Sub", {x, parts.reduced("ReduceMean", x, axes)});
  const std::string variance = parts.reduced("ReduceMean", parts.add("Mul", {off, off}), axes);
  return parts.add("Div", {off, parts.add("Sqrt", {parts.add("Add", {variance, parts.number(epsilon)})})});
}

inline void divide_layer_normalization(TangentParts& parts) {
  const auto rank = static_cast<std::int64_t>(parts.shape(parts.input(0)).size());
  const std::int64_t axis = attribute_of<std::int64_t>(parts.node(), "axis", -1);
  std::vector<std::int64_t> axes;
  for (std::int64_t a = axis < 0 ? axis + rank : axis; a < rank; ++a) axes.push_back(a);
  const std::string normal =
      normalised(parts, parts.input(0), axes, attribute_of(parts.node(), "epsilon", 1e-5));
  if (parts.node().inputs.size() < 3) return parts.finish(0, "Mul", {normal, parts.input(1)});
  parts.finish(0, "Add", {parts.add("Mul", {normal, parts.input(1)}), parts.input(2)});
}

inline void divide_group_normalization(TangentParts& parts) {
  const Shape x = parts.shape(parts.input(0));
  const auto channels = static_cast<std::int64_t>(x[1]);
  const auto groups = static_cast<std::size_t>(attribute_of(parts.node(), "num_groups", channels));
  const std::string rows =
      parts.reshaped(parts.input(0), {x[0], groups, groups == 0 ? 0 : size_of(x) / (x[0] * groups)});
  const std::string normal =
      parts.reshaped(normalised(parts, rows, {2}, attribute_of(parts.node(), "epsilon", 1e-5)), x);
  Shape map(x.size() - 1, 1);
  map[0] = x[1];
  const auto weight = [&](std::size_t i) {
    const std::size_t count = parts.shape(parts.input(i))[0];
    if (count == x[1]) return parts.reshaped(parts.input(i), map);
    const std::string column = parts.reshaped(parts.input(i), {count, 1});
    const std::vector<std::int64_t> extents{static_cast<std::int64_t>(count),
                                            channels / static_cast<std::int64_t>(count)};
    return parts.reshaped(parts.add("Expand", {column, parts.integers(extents)}), map);
  };
  parts.finish(0, "Add", {parts.add("Mul", {normal, weight(1)}), weight(2)});
}

/// x / (bias + α · (mean of x² over `size` neighbouring channels))^β.
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
  const std::string power = parts.add("Pow", {sum, parts.number(attribute_of(node, "beta", 0.75))});
  parts.finish(0, "Div", {x, parts.reshaped(power, shape)});
}

/// (Σ |x|^p)^(1/p) of pooled pixels. Its derivative where all are 0 is not a number.
inline void divide_norm_pool(TangentParts& parts) {
  const Node& node = parts.node();
  const std::int64_t p = attribute_of<std::int64_t>(node, "p", 2);
  const std::string powers =
      parts.add("Pow", {parts.add("Abs", {parts.input(0)}), parts.number(static_cast<double>(p))});
  std::string sum;
  if (node.operation == "GlobalLpPool") {
    sum = parts.reduced("ReduceSum", powers, {2, 3});
  } else {
    if (attribute_of<std::int64_t>(node, "ceil_mode", 0) != 0) parts.refuse();
    auto attributes = node.attributes;
    attributes.erase("p");
    attributes["count_include_pad"] = std::int64_t(1);
    double taps = 1;
    for (const std::int64_t count : attribute_of(node, "kernel_shape", std::vector<std::int64_t>()))
      taps *= static_cast<double>(count);
    sum = parts.add("Mul", {parts.add("AveragePool", {powers}, attributes), parts.number(taps)});
  }
  parts.finish(0, "Pow", {sum, parts.number(1 / static_cast<double>(p))});
}

inline void divide_absolute_sum(TangentParts& parts) {
  const bool keeps = attribute_of<std::int64_t>(parts.node(), "keepdims", 1) != 0;
  const std::string sum = parts.reduced("ReduceSum", parts.add("Abs", {parts.input(0)}), parts.axes(), keeps);
  parts.finish(0, "Identity", {sum});
}

/// Names of a description's values.
[[nodiscard]] inline ValueNames names_of(const NetworkDescription& description) {
  ValueNames names;
  for (const InputDescription& input : description.inputs) names.taken.insert(input.name);
  for (const auto& [name, constant] : description.constants) names.taken.insert(name);
  for (const Node& node : description.nodes) names.taken.insert(node.outputs.begin(), node.outputs.end());
  return names;
}

/// Writes each node, by write(parts) where `rule` returns a rule and otherwise unchanged.
template <class RuleOf>
void rewrite(NetworkDescription& description, const NetworkFacts& facts, ValueNames& names,
             std::map<std::string, std::string>& tangents, const RuleOf& rule_of) {
  PlanBudget budget;
  std::vector<Node> nodes;
  for (Node& node : description.nodes) {
    if (const TangentRule rule = rule_of(node); rule != nullptr) {
      TangentParts parts(node, description.opset, names, budget, facts, tangents);
      rule(parts);
      Decomposition written = parts.take();
      std::ranges::move(written.nodes, std::back_inserter(nodes));
      description.constants.merge(written.constants);
    } else {
      nodes.push_back(std::move(node));
    }
  }
  description.nodes = std::move(nodes);
}
}  // namespace detail

NetworkDescription divided_for_tangents(NetworkDescription description, const NetworkFacts& facts) {
  static const std::map<std::string, detail::TangentRule, std::less<>> rules{
      {"LayerNormalization", detail::divide_layer_normalization},
      {"GroupNormalization", detail::divide_group_normalization},
      {"InstanceNormalization", detail::divide_group_normalization},
      {"LRN", detail::divide_local_normalization},
      {"LpPool", detail::divide_norm_pool},
      {"GlobalLpPool", detail::divide_norm_pool},
      {"ReduceL1", detail::divide_absolute_sum}};
  ValueNames names = detail::names_of(description);
  std::map<std::string, std::string> none;
  detail::rewrite(description, facts, names, none, [&](const Node& node) -> detail::TangentRule {
    const auto found = rules.find(node.operation);
    return found == rules.end() || facts.at(node.outputs.front()).constant != nullptr ? nullptr
                                                                                      : found->second;
  });
  return description;
}

NetworkDescription tangent_network(NetworkDescription description, const NetworkFacts& facts) {
  static const std::set<std::string, std::less<>> steps{
      "Ceil", "ConstantOfShape", "EyeLike", "Floor", "Hardmax", "OneHot", "Range", "Round", "Sign"};
  ValueNames names = detail::names_of(description);
  std::map<std::string, std::string> tangents;
  const std::vector<InputDescription> inputs = description.inputs;
  for (const InputDescription& input : inputs) {
    if (input.type != ElementType::floating) continue;
    const Shape& shape = facts.at(input.name).shape;
    tangents[input.name] = names.next(input.name);
    description.inputs.push_back({tangents[input.name], {shape.begin(), shape.end()}});
  }
  detail::rewrite(description, facts, names, tangents, [&](const Node& node) -> detail::TangentRule {
    const auto is_smooth = [&](const std::string& output) {
      return !output.empty() && facts.at(output).type == ElementType::floating;
    };
    const bool varies =
        std::ranges::any_of(node.inputs, [&](const auto& input) { return tangents.contains(input); });
    if (!varies || steps.contains(node.operation) || std::ranges::none_of(node.outputs, is_smooth))
      return nullptr;
    const auto rule = detail::tangent_rules().find(node.operation);
    if (rule == detail::tangent_rules().end())
      throw DomainError({"second order of ", label_of(node), " is not known"});
    return rule->second;
  });
  const auto outputs = description.outputs;
  for (const std::string& output : outputs) {
    if (const auto found = tangents.find(output); found != tangents.end()) {
      description.outputs.push_back(found->second);
      continue;
    }
    const ValueFacts& own = facts.at(output);
    const Shape& shape = own.constant != nullptr ? own.constant->shape : own.shape;
    description.outputs.push_back(names.next(output));
    description.constants[description.outputs.back()] = {shape, ElementType::floating,
                                                         std::vector<double>(size_of(shape))};
  }
  auto all = description.outputs;
  return pruned(std::move(description), std::move(all));
}

}  // namespace tapestry::nn

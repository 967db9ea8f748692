#pragma once
#include <tapestry/nn/detail/network/operators.hpp>
#include <tapestry/nn/detail/network/plan_budget.hpp>

namespace tapestry::nn {
/// Nodes that take the place of one, and the constants that they read.
struct Decomposition {
  std::vector<Node> nodes{};
  std::map<std::string, Constant> constants{};
};

/// Names of a network's values, with new ones between parts.
struct ValueNames {
  std::set<std::string> taken{};
  std::map<std::string, std::size_t> counts{};            ///< numbers that stems have had
  std::map<const Constant*, std::string> of_constants{};  ///< of graphs within nodes, written once

  /// A new name: the stem and a number.
  [[nodiscard]] std::string next(const std::string& stem) {
    std::string name;
    std::size_t& count = counts[stem];
    do name = stem + "#" + std::to_string(count++);
    while (!taken.insert(name).second);
    return name;
  }
};

/// Writes the nodes that take the place of one. Values between them get its first
/// result's name with a number.
class Decomposer {
 public:
  using Names = std::vector<std::string>;
  using Attributes = std::map<std::string, Attribute>;

  /// \param budget of nodes; all members throw Error (limit) when it is used up
  Decomposer(const Node& node, std::int64_t opset, ValueNames& names, PlanBudget& budget)
      : node_(node), opset_(opset), names_(names), budget_(budget) {
    for (const auto& output : node.outputs)
      if (stem_.empty()) stem_ = output;
  }

  [[nodiscard]] const Node& node() const { return node_; }
  [[nodiscard]] const std::string& input(std::size_t i) const { return node_.inputs.at(i); }

  /// Adds a node, and returns its result.
  std::string add(const char* operation, Names inputs, Attributes attributes = {}) {
    std::string name = next_name();
    push({node_.name, operation, std::move(inputs), {name}, std::move(attributes)});
    return name;
  }
  /// Adds a node with results of these names, which are new ones where they are empty. Returns them.
  Names add_all(const std::string& operation, Names inputs, Attributes attributes, Names outputs) {
    for (std::string& output : outputs)
      if (output.empty()) output = next_name();
    push({node_.name, operation, std::move(inputs), outputs, std::move(attributes)});
    return outputs;
  }
  /// Adds a node that makes the result i, unless the node leaves that out.
  void finish(std::size_t i, const char* operation, Names inputs, Attributes attributes = {}) {
    if (i >= node_.outputs.size() || node_.outputs[i].empty()) return;
    push({node_.name, operation, std::move(inputs), {node_.outputs[i]}, std::move(attributes)});
  }
  /// Makes the result i of a value within bounds.
  void finish_clipped(std::size_t i, const std::string& value, double least, double most) {
    if (opset_ >= 11) return finish(i, "Clip", {value, number(least), number(most)});
    finish(i, "Clip", {value}, {{"min", least}, {"max", most}});
  }
  /// Adds a node that makes all results.
  void finish_all(const char* operation, Names inputs, Attributes attributes) {
    push({node_.name, operation, std::move(inputs), node_.outputs, std::move(attributes)});
  }

  std::string integers(const std::vector<std::int64_t>& values) {
    return constant(
        {{values.size()}, ElementType::integer, std::vector<double>(values.begin(), values.end())});
  }
  std::string number(double value) {
    return constant({{}, ElementType::floating, std::vector<double>{value}});
  }
  std::string constant(Constant constant) {
    std::string name = next_name();
    parts_.constants.emplace(name, std::move(constant));
    return name;
  }

  std::string reshaped(const std::string& value, const Shape& shape) {
    return add("Reshape", {value, integers({shape.begin(), shape.end()})}, {{"allowzero", std::int64_t{1}}});
  }
  std::string transposed(const std::string& value, const std::vector<std::size_t>& order) {
    return add("Transpose", {value}, {{"perm", std::vector<std::int64_t>(order.begin(), order.end())}});
  }
  /// Elements first, first + step, … below end along an axis.
  std::string sliced(const std::string& value, std::int64_t first, std::int64_t end, std::int64_t axis,
                     std::int64_t step = 1) {
    if (opset_ >= 10)
      return add("Slice", {value, integers({first}), integers({end}), integers({axis}), integers({step})});
    std::vector<std::int64_t> places;  // Slice has no steps before
    for (std::int64_t place = first; place < end; place += step) places.push_back(place);
    return add("Gather", {value, integers(places)}, {{"axis", axis}});
  }
  /// With zeros around it. \param pads  before the value along each axis, then behind it
  std::string padded(const std::string& value, const std::vector<std::int64_t>& pads) {
    if (opset_ >= 11) return add("Pad", {value, integers(pads)});
    return add("Pad", {value}, {{"pads", pads}});
  }
  /// Adds an axis of extent 1.
  std::string raised(const std::string& value, std::int64_t axis = 0) {
    auto [inputs, attributes] = along(value, {axis});
    return add("Unsqueeze", std::move(inputs), std::move(attributes));
  }
  /// Reduces along some axes, by ReduceMean and the like; the axes stay with extent 1, or go.
  std::string reduced(const char* operation, const std::string& value, const std::vector<std::int64_t>& axes,
                      bool keeps_axes = true) {
    auto [inputs, attributes] = along(value, axes, std::string_view(operation) == "ReduceSum" ? 13 : 18);
    attributes["keepdims"] = std::int64_t{keeps_axes};
    return add(operation, std::move(inputs), std::move(attributes));
  }
  /// Makes the result i of a value without an axis of extent 1.
  void squeeze(std::size_t i, const std::string& value, std::int64_t axis) {
    auto [inputs, attributes] = along(value, {axis});
    finish(i, "Squeeze", std::move(inputs), std::move(attributes));
  }

  /// Writes the nodes of a subgraph.
  /// \param names  of its inputs and of what it captures, in the graph around it
  /// \returns the names of its results
  Names inlined(const Subgraph& graph, std::map<std::string, std::string> names) {
    const auto renamed = [&](const std::string& name) { return name.empty() ? name : names.at(name); };
    for (const auto& [name, value] : graph.constants) {
      const auto [shared, is_new] = names_.of_constants.try_emplace(&value);
      if (is_new) shared->second = constant(value);
      names[name] = shared->second;
    }
    for (const Node& node : graph.nodes) {
      Node& copy = push(node);
      for (std::string& input : copy.inputs) input = renamed(input);
      for (std::string& output : copy.outputs)
        if (!output.empty()) output = names[output] = next_name();
    }
    Names results;
    for (const std::string& output : graph.outputs) results.push_back(renamed(output));
    return results;
  }

  [[nodiscard]] Decomposition take() { return std::move(parts_); }

 private:
  Node& push(Node node) {
    budget_.take_node(node.inputs.size());
    return parts_.nodes.emplace_back(std::move(node));
  }

  /// A value with axes, which are an operand since some opset, and an attribute before.
  [[nodiscard]] std::pair<Names, Attributes> along(const std::string& value,
                                                   const std::vector<std::int64_t>& axes,
                                                   std::int64_t since = 13) {
    if (opset_ >= since) return {{value, integers(axes)}, {}};
    return {{value}, {{"axes", axes}}};
  }

  [[nodiscard]] std::string next_name() { return names_.next(stem_); }

  const Node& node_;
  std::int64_t opset_;
  ValueNames& names_;
  PlanBudget& budget_;
  std::string stem_{};
  Decomposition parts_{};
};

/// An operator that is made of others.
struct Decomposable {
  std::vector<OperandCount> operands;  ///< empty: the counts of the operator that it becomes
  /// Takes a node apart. \throws DomainError or ShapeError for unsupported nodes
  std::function<void(OperatorContext&, Decomposer&)> decompose;
  /// Whether a node is taken apart; null: always. Other nodes are made unchanged.
  bool (*applies)(const OperatorContext&) = nullptr;
};

/// Operators that are made of others, by their names.
[[nodiscard]] const std::map<std::string, Decomposable, std::less<>>& decompositions();
}  // namespace tapestry::nn

#pragma once
#include <tapestry/nn/detail/network/decomposition.hpp>
#include <tapestry/nn/detail/network/simplify/editable_graph.hpp>

namespace tapestry::nn {
/// The same network with simpler nodes in place of normalisations, of quotients and of activations that are
/// fused with an addition or have a curve. \param facts  of all values
[[nodiscard]] NetworkDescription divided_for_tangents(NetworkDescription description,
                                                      const NetworkFacts& facts);

/// A network so divided, with its derivative along a direction, see Network::with_tangents().
/// \param facts    of all values
/// \param weights  names of constants that have a tangent, too
/// \throws DomainError naming an operator of which the tangent is not known
[[nodiscard]] NetworkDescription tangent_network(NetworkDescription description, const NetworkFacts& facts,
                                                 const std::set<std::string>& weights);

/// Writes the nodes of one node's result and of its tangent.
class TangentParts : public Decomposer {
 public:
  /// \param tangents  their names, by those of the values that depend on an input; receives the results'
  TangentParts(const Node& node, std::int64_t opset, ValueNames& names, PlanBudget& budget,
               const NetworkFacts& facts, std::map<std::string, std::string>& tangents)
      : Decomposer(node, opset, names, budget), opset_(opset), facts_(facts), tangents_(tangents) {}

  [[nodiscard]] std::int64_t opset() const { return opset_; }
  [[nodiscard]] const std::string& result() const { return node().outputs.front(); }
  [[nodiscard]] const Shape& shape(const std::string& value) const {
    const ValueFacts& facts = facts_.at(value);
    return facts.constant != nullptr ? facts.constant->shape : facts.shape;
  }
  [[nodiscard]] bool is_number(const std::string& value) const {
    const ValueFacts& facts = facts_.at(value);
    return (facts.constant != nullptr ? facts.constant->type : facts.type) == ElementType::floating;
  }

  [[nodiscard]] bool varies(std::size_t i) const {
    return i < node().inputs.size() && tangents_.contains(input(i));
  }
  /// The tangent of a value: zeros of its extents if it does not vary.
  [[nodiscard]] std::string tangent(const std::string& value) {
    if (const auto found = tangents_.find(value); found != tangents_.end()) return found->second;
    const Shape& own = shape(value);
    return constant({own, ElementType::floating, std::vector<double>(size_of(own))});
  }
  [[nodiscard]] std::string tangent(std::size_t i) { return tangent(input(i)); }

  /// Writes the node itself.
  void keep() { add_all(node().operation, node().inputs, node().attributes, node().outputs); }
  /// Writes a node of the same operator with other operands.
  [[nodiscard]] Names same(Names inputs) {
    return add_all(node().operation, std::move(inputs), node().attributes, Names(node().outputs.size()));
  }
  /// States the tangents of the results.
  void set(const Names& results) {
    for (std::size_t i = 0; i < results.size(); ++i)
      if (!node().outputs[i].empty()) tangents_[node().outputs[i]] = results[i];
  }
  void set(const std::string& result) { set(Names{result}); }
  /// A value repeated to the result's extents.
  [[nodiscard]] std::string expanded(const std::string& value, const Shape& from) {
    const Shape& to = shape(result());
    return from == to ? value : add("Expand", {value, integers({to.begin(), to.end()})});
  }
  /// Axes of a reduction, all if the node states none.
  [[nodiscard]] std::vector<std::int64_t> axes() const;

  [[noreturn]] void refuse() const {
    throw DomainError({"second order of ", label_of(node()), " is not known"});
  }

 private:
  std::int64_t opset_;
  const NetworkFacts& facts_;
  std::map<std::string, std::string>& tangents_;
};
}  // namespace tapestry::nn

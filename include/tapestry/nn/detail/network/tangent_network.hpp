#pragma once
#include <tapestry/nn/detail/network/decomposition.hpp>
#include <tapestry/nn/detail/network/simplify/editable_graph.hpp>

namespace tapestry::nn {

/// The same network with nodes in place of those operators that have no tangent of their own: normalisations
/// and norms that depend on an input. \param facts  of all values
[[nodiscard]] NetworkDescription divided_for_tangents(NetworkDescription description,
                                                      const NetworkFacts& facts);

/// A network and its derivative along a direction, by ordinary nodes and Tangent:
///
///   inputs (x …, ẋ …), outputs (y …, ẏ …)    y = f(x)    ẏ = J(x)·ẋ
///
/// The adjoint of seeds (a on y, b on ẏ) is x̄ = Jᵀa + D(Jᵀb)[ẋ] and Jᵀb for ẋ: a gradient and a product with
/// the Hessian. Each input of floating-point numbers has a tangent, and each output; it is 0 where nothing
/// depends on an input.
///
/// \param facts  of all values
/// \throws DomainError naming an operator of which the tangent is not known
[[nodiscard]] NetworkDescription tangent_network(NetworkDescription description, const NetworkFacts& facts);

/// Writes the nodes of one node's result and of its tangent.
class TangentParts : public Decomposer {
 public:
  /// \param tangents  names by those of the values that depend on an input; receives the results'
  TangentParts(const Node& node, std::int64_t opset, ValueNames& names, PlanBudget& budget,
               const NetworkFacts& facts, std::map<std::string, std::string>& tangents)
      : Decomposer(node, opset, names, budget), opset_(opset), facts_(facts), tangents_(tangents) {}

  [[nodiscard]] std::int64_t opset() const { return opset_; }
  [[nodiscard]] const std::string& result() const { return node().outputs.front(); }
  [[nodiscard]] const ValueFacts& facts_of(const std::string& value) const { return facts_.at(value); }
  [[nodiscard]] const Shape& shape(const std::string& value) const {
    const ValueFacts& facts = facts_of(value);
    return facts.constant != nullptr ? facts.constant->shape : facts.shape;
  }

  [[nodiscard]] bool is_number(const std::string& value) const {
    const ValueFacts& facts = facts_of(value);
    return (facts.constant != nullptr ? facts.constant->type : facts.type) == ElementType::floating;
  }

  [[nodiscard]] bool varies(const std::string& value) const { return tangents_.contains(value); }
  [[nodiscard]] bool varies(std::size_t i) const { return i < node().inputs.size() && varies(input(i)); }
  /// The tangent of a value: zeros of its extents if it does not vary.
  [[nodiscard]] std::string tangent(const std::string& value) {
    return varies(value) ? tangents_.at(value) : zeros(shape(value));
  }
  [[nodiscard]] std::string tangent(std::size_t i) { return tangent(input(i)); }
  [[nodiscard]] std::string zeros(const Shape& extents) {
    return constant({extents, ElementType::floating, std::vector<double>(size_of(extents))});
  }

  /// Writes the node itself, unchanged.
  void keep() {
    static_cast<void>(add_all(node().operation, node().inputs, node().attributes, node().outputs));
  }
  /// A node of the same operator with other operands.
  [[nodiscard]] Names same(Names inputs) {
    return add_all(node().operation, std::move(inputs), node().attributes, Names(node().outputs.size()));
  }
  void set(const std::string& tangent, std::size_t i = 0) {
    if (!node().outputs[i].empty()) tangents_[node().outputs[i]] = tangent;
  }
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

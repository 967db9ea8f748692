#pragma once
#include <algorithm>
#include <set>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/nn/detail/network/decomposition.hpp>
#include <tapestry/nn/detail/network/operators.hpp>
#include <tapestry/nn/network/program_builder.hpp>
#include <vector>

namespace tapestry::nn {

template <std::floating_point T>
bool ProgramBuilder<T>::take_apart(const Node& node, const Decomposable& kind) {
  std::vector<Operand> operands;
  for (const std::string& input : node.inputs) operands.push_back(operand_of(input, false));
  OperatorContext context(node, description_.opset, std::move(operands), false);
  if (kind.applies != nullptr && !kind.applies(context)) return false;
  if (!kind.operands.empty())
    require_operand_count(operand_count(context.inputs), description_.opset, kind.operands);
  Decomposer decomposer(node, description_.opset, names());
  kind.decompose(context, decomposer);
  context.require_all_asked();
  constexpr std::size_t most_parts = std::size_t(1) << 20U;
  const Decomposition& parts = taken_apart_[&node] = decomposer.take();
  part_count_ += parts.nodes.size();
  if (part_count_ > most_parts) throw DomainError({"more than ", most_parts, " nodes with those of loops"});
  for (const auto& [name, constant] : parts.constants) known_[name].constant = &constant;
  for (const Node& part : parts.nodes) add_node(part);
  return true;
}

template <std::floating_point T>
std::set<std::string>& ProgramBuilder<T>::names() {
  if (!names_.empty()) return names_;
  for (const InputDescription& input : description_.inputs) names_.insert(input.name);
  for (const auto& [name, constant] : description_.constants) names_.insert(name);
  for (const Node& node : description_.nodes) names_.insert(node.outputs.begin(), node.outputs.end());
  return names_;
}

template <std::floating_point T>
void ProgramBuilder<T>::expand(NetworkDescription& description) const {
  if (taken_apart_.empty()) return;
  DividedNodes nodes = divided();  // build() has left none
  description.nodes = std::move(nodes.made);
  description.constants.merge(nodes.constants);
}

template <std::floating_point T>
typename ProgramBuilder<T>::DividedNodes ProgramBuilder<T>::divided() const {
  DividedNodes nodes;
  for (const Node& node : description_.nodes) divide(node, nodes);
  for (const auto& [node, parts] : taken_apart_)
    nodes.constants.insert(parts.constants.begin(), parts.constants.end());
  return nodes;
}

template <std::floating_point T>
void ProgramBuilder<T>::divide(const Node& node, DividedNodes& nodes) const {
  if (const auto found = taken_apart_.find(&node); found != taken_apart_.end()) {
    for (const Node& part : found->second.nodes) divide(part, nodes);
    return;
  }
  const bool has_failed = std::ranges::any_of(node.outputs, [&](const std::string& name) {
    const auto known = known_.find(name);
    return !name.empty() && (known == known_.end() || known->second.failed);
  });
  (has_failed ? nodes.left : nodes.made).push_back(node);
}

template <std::floating_point T>
WeightBlock ProgramBuilder<T>::block_of(const ProgramValue& value) const {
  WeightBlock block{value.name, value.shape, value.constant, {}, value.shape, description_.opset};
  for (const Known* known = &known_.at(block.name); known->moved_by != nullptr;) {
    WeightMove move{*known->moved_by, known->moved_result, {}};
    for (std::size_t i = 1; i < move.node.inputs.size(); ++i)
      move.settings.push_back(move.node.inputs[i].empty() ? Constant()
                                                          : *known_.at(move.node.inputs[i]).constant);
    block.name = move.node.inputs.front();
    block.moves.insert(block.moves.begin(), std::move(move));
    known = &known_.at(block.name);
    block.constant_shape = shape_of(*known);
  }
  return block;
}

}  // namespace tapestry::nn

#pragma once
#include <tapestry/nn/network/program_builder.hpp>

namespace tapestry::nn {
template <std::floating_point T>
void ProgramBuilder<T>::add_nodes() {
  for (const Node& node : description_.nodes) {
    root_ = &node;
    waiting_.push_back({&node, std::ranges::any_of(node.outputs, [&](const std::string& name) {
                          return repeated_before_.contains(name);
                        })});
    while (!waiting_.empty()) {
      const Waiting next = waiting_.back();
      waiting_.pop_back();
      is_repeated_ = next.is_repeated;
      add_node(*next.node);
    }
  }
}

template <std::floating_point T>
bool ProgramBuilder<T>::take_apart(const Node& node, const Decomposable& kind) {
  std::vector<Operand> operands;
  for (const std::string& input : node.inputs) operands.push_back(operand_of(input, false));
  OperatorContext context(node, description_.opset, std::move(operands), false);
  if (kind.applies != nullptr && !kind.applies(context)) return false;
  if (!kind.operands.empty())
    require_operand_count(operand_count(context.inputs), description_.opset, kind.operands);
  Decomposer decomposer(node, description_.opset, names(), budget_);
  kind.decompose(context, decomposer);
  context.require_all_asked();
  const Decomposition& parts = taken_apart_[&node] = decomposer.take();
  for (const auto& [name, constant] : parts.constants) known_[name].constant = &constant;
  for (auto part = parts.nodes.rbegin(); part != parts.nodes.rend(); ++part)
    waiting_.push_back({&*part, is_repeated_ || node.operation == "Loop"});
  return true;
}

template <std::floating_point T>
ValueNames& ProgramBuilder<T>::names() {
  std::set<std::string>& taken = names_.taken;
  if (!taken.empty()) return names_;
  for (const InputDescription& input : description_.inputs) taken.insert(input.name);
  for (const auto& [name, constant] : description_.constants) taken.insert(name);
  for (const Node& node : description_.nodes) taken.insert(node.outputs.begin(), node.outputs.end());
  return names_;
}

template <std::floating_point T>
void ProgramBuilder<T>::take_repeated(const Node& node, const Operation<T>& operation) {
  std::size_t bytes = 0;
  for (const auto& result : operation.results()) bytes += sizeof(T) * size_of(result.shape);
  for (const std::string& input : node.inputs) {
    if (input.empty()) continue;
    const Known& known = known_.at(input);
    budget_.take(&PlanBudget::reads, size_of(shape_of(known)), "elements read in loops");
    if (known.constant != nullptr && repeated_constants_.insert(known.constant).second)
      bytes += sizeof(T) * known.constant->size();
  }
  budget_.take(&PlanBudget::bytes, bytes, "bytes in loops");
}

template <std::floating_point T>
std::string ProgramBuilder<T>::label_of_part(const Node& node) const {
  const std::string whole = label_of(*root_) + " (opset " + std::to_string(description_.opset) + ")";
  return root_ == &node ? whole : whole + ": its part " + label_of(node);
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
  std::vector<const Node*> waiting;
  for (auto node = description_.nodes.rbegin(); node != description_.nodes.rend(); ++node)
    waiting.push_back(&*node);
  while (!waiting.empty()) {
    const Node& node = *waiting.back();
    waiting.pop_back();
    if (const auto found = taken_apart_.find(&node); found != taken_apart_.end()) {
      const auto& parts = found->second.nodes;
      for (auto part = parts.rbegin(); part != parts.rend(); ++part) waiting.push_back(&*part);
      continue;
    }
    const bool has_failed = std::ranges::any_of(node.outputs, [&](const std::string& name) {
      const auto known = known_.find(name);
      return !name.empty() && (known == known_.end() || known->second.failed);
    });
    (has_failed ? nodes.left : nodes.made).push_back(node);
  }
  for (const auto& [node, parts] : taken_apart_)
    nodes.constants.insert(parts.constants.begin(), parts.constants.end());
  return nodes;
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

#pragma once
#include <tapestry/nn/network/program_builder.hpp>
#include <tapestry/nn/network/staged_network.hpp>

namespace tapestry::nn {
namespace detail {
/// Whether a node's results are chosen by the values of its operands, without a derivative.
[[nodiscard]] inline bool chooses_by_values(const Node& node) {
  return node.operation == "NonMaxSuppression" || node.operation == "NonZero";
}

[[nodiscard]] inline bool is_same(const Constant& a, const Constant& b) {
  return a.type == b.type && a.shape == b.shape && a.values == b.values;
}

[[nodiscard]] inline bool is_same(const std::map<std::string, Constant>& a,
                                  const std::map<std::string, Constant>& b) {
  return std::ranges::equal(a, b, [](const auto& one, const auto& other) {
    return one.first == other.first && is_same(one.second, other.second);
  });
}

/// \throws FileError (mismatch) naming operators that no network has, also within the nodes' graphs
template <std::floating_point T>
void require_known_operators(const std::string& path, const std::vector<Node>& nodes) {
  for (const Node& node : nodes) {
    const std::string& name = node.operation;
    if (!operators<T>().contains(name) && !decompositions().contains(name) && name != "Shape" &&
        name != "Size")
      throw file_mismatch({path, "", label_of(node) + ": the operator is not supported"});
    for (const auto& [key, value] : node.attributes)
      if (const auto* graph = std::get_if<std::shared_ptr<const Subgraph>>(&value))
        require_known_operators<T>(path, (*graph)->nodes);
  }
}
}  // namespace detail

template <std::floating_point T>
StagedNetwork<T>::StagedNetwork(NetworkDescription description, const std::map<std::string, Shape>& shapes,
                                PlanBudget budget)
    : inputs_(description.inputs),
      shapes_(Network<T>::input_shapes(description, shapes)),
      outputs_(description.outputs) {
  detail::require_known_operators<T>(description.path, description.nodes);
  Stage stage;
  stage.shapes = shapes_;
  stage.budget = std::move(budget);
  first_ = made(std::move(description), std::move(stage));
}

template <std::floating_point T>
void StagedNetwork<T>::set_engine(Engine engine) {
  engine_ = engine;
  if (first_->network) first_->network->set_engine(engine);
}

template <std::floating_point T>
auto StagedNetwork<T>::made(NetworkDescription description, Stage stage) -> std::shared_ptr<const Stage> {
  if (stage.before) try {
      stage.budget.take(&PlanBudget::stages, 1, "networks, one after another as values come to be known,");
      stage.budget.take(&PlanBudget::planned, description.nodes.size(), "nodes planned anew");
    } catch (const Error& error) {
      throw FileError(error.kind(), {description.path, "", error.what()});
    }
  ProgramBuilder<T> finder(description, stage.shapes, false, false, std::move(stage.budget));
  finder.add_nodes();
  stage.budget = finder.budget();
  auto [nodes, left, constants] = finder.divided();
  // Without new nodes the next stage would equal this one, but for choices by the inputs' values.
  const bool may_choose = !stage.before && std::ranges::any_of(left, detail::chooses_by_values);
  if (nodes.empty() && left.size() == description.nodes.size() && !may_choose) finder.require_no_problems();
  const NetworkFacts facts = finder.facts();
  std::set<std::string> wanted(description.outputs.begin(), description.outputs.end());
  for (const Node& node : left) wanted.insert(node.inputs.begin(), node.inputs.end());
  description.constants.merge(constants);
  stage.rest = {description.path, description.opset, {}, description.outputs, {}, std::move(left), {}, {}};
  for (const std::string& name : wanted) {
    const auto found = facts.find(name);
    if (found == facts.end()) continue;
    if (found->second.constant != nullptr) {
      stage.rest.constants[name] = *found->second.constant;
    } else if (!stage.shapes.contains(name)) {
      stage.outputs.push_back(name);
      stage.types.push_back(found->second.type);
    }
  }
  if (stage.outputs.empty()) return std::make_shared<const Stage>(std::move(stage));
  description.nodes = std::move(nodes);
  description = pruned(std::move(description), stage.outputs);
  std::set<std::string> read;
  for (const Node& node : description.nodes) read.insert(node.inputs.begin(), node.inputs.end());
  std::erase_if(description.inputs,
                [&](const InputDescription& input) { return !read.contains(input.name); });
  for (const InputDescription& input : description.inputs) stage.inputs.push_back(input.name);
  stage.network = std::make_unique<Network<T>>(std::move(description), stage.shapes);
  return std::make_shared<const Stage>(std::move(stage));
}

template <std::floating_point T>
void StagedNetwork<T>::choose(const Stage& before, const StagedPass<T>& pass,
                              std::map<std::string, Constant>& found) {
  for (const Node& node : before.rest.nodes) {
    if (!detail::chooses_by_values(node)) continue;
    std::vector<Constant> copies(node.inputs.size());
    std::vector<FoldOperand> operands;
    bool is_known = true;
    for (std::size_t i = 0; i < node.inputs.size(); ++i) {
      const std::string& name = node.inputs[i];
      if (const auto own = before.rest.constants.find(name); own != before.rest.constants.end()) {
        copies[i] = own->second;
      } else if (const auto integers = found.find(name); integers != found.end()) {
        copies[i] = integers->second;
      } else if (const auto value = pass.known_.find(name); value != pass.known_.end()) {
        const auto& [values, shape, type] = value->second;
        copies[i] = {shape, type, std::vector<double>(values, values + size_of(shape))};
      } else if (!name.empty()) {
        is_known = false;
      }
      operands.push_back({&copies[i], copies[i].shape, !name.empty()});
    }
    if (!is_known) continue;
    try {
      auto results = fold_node<T>(node, before.rest.opset, operands, before.budget.folded);
      found[node.outputs.front()] = std::move(results.front());
    } catch (const Error& error) {
      throw file_mismatch({before.rest.path, "", label_of(node) + ": " + std::string(error.what())});
    }
  }
}

template <std::floating_point T>
auto StagedNetwork<T>::next(const std::shared_ptr<const Stage>& before, StagedPass<T>& pass,
                            const std::shared_ptr<const Stage>& last) const -> std::shared_ptr<const Stage> {
  Stage stage;
  stage.before = before;
  stage.engine = engine_;
  stage.budget = before->budget;
  for (const auto& [name, value] : pass.known_) {
    if (value.type == ElementType::floating)
      stage.shapes[name] = value.shape;
    else
      stage.found[name] = {value.shape, value.type,
                           std::vector<double>(value.values, value.values + size_of(value.shape))};
  }
  choose(*before, pass, stage.found);
  if (last && last->before == before && last->engine == engine_ && last->shapes == stage.shapes &&
      detail::is_same(last->found, stage.found))
    return last;
  ++pass.made_count_;
  NetworkDescription rest = before->rest;
  for (const auto& [name, shape] : stage.shapes)
    rest.inputs.push_back({name, {shape.begin(), shape.end()}, ElementType::floating});
  std::erase_if(rest.nodes, [&](const Node& node) { return stage.found.contains(node.outputs.front()); });
  rest.constants.insert(stage.found.begin(), stage.found.end());
  auto next = made(std::move(rest), std::move(stage));
  if (engine_ && next->network) next->network->set_engine(*engine_);
  return next;
}

template <std::floating_point T>
void StagedNetwork<T>::run(StagedPass<T>& pass, typename StagedPass<T>::Run& run, Mode mode) const {
  const Stage& stage = *run.stage;
  if (!stage.network) return;
  std::vector<const T*> inputs;
  for (const std::string& name : stage.inputs) inputs.push_back(pass.known_.at(name).values);
  stage.network->forward(inputs, run.pass, mode);
  for (std::size_t i = 0; i < stage.outputs.size(); ++i)
    pass.known_[stage.outputs[i]] = {run.pass.output(i), stage.network->output_shape(i), stage.types[i]};
}

template <std::floating_point T>
void StagedNetwork<T>::forward(const std::vector<const T*>& inputs, StagedPass<T>& pass, Mode mode) const {
  if (inputs.size() != inputs_.size())
    throw ShapeError({"StagedNetwork: ", inputs.size(), " inputs, expected ", inputs_.size()});
  pass.known_.clear();
  pass.made_count_ = 0;
  for (std::size_t i = 0; i < inputs.size(); ++i)
    pass.known_[inputs_[i].name] = {inputs[i], input_shape(i), inputs_[i].type};
  std::shared_ptr<const Stage> stage = first_;
  std::size_t count = 0;
  for (;; ++count) {
    if (count == pass.runs_.size()) pass.runs_.push_back(std::make_unique<typename StagedPass<T>::Run>());
    auto& run = *pass.runs_[count];
    run.stage = stage;
    this->run(pass, run, mode);
    if (stage->rest.nodes.empty()) break;
    stage = next(stage, pass, count + 1 < pass.runs_.size() ? pass.runs_[count + 1]->stage : nullptr);
  }
  pass.runs_.resize(count + 1);
  take_outputs(pass, *stage);
}

template <std::floating_point T>
void StagedNetwork<T>::take_outputs(StagedPass<T>& pass, const Stage& last) const {
  pass.outputs_.clear();
  for (const std::string& name : outputs_) {
    if (const auto known = pass.known_.find(name); known != pass.known_.end()) {
      pass.outputs_.push_back(known->second);
      continue;
    }
    const auto found = last.rest.constants.find(name);
    if (found == last.rest.constants.end())
      throw file_mismatch({last.rest.path, "", "nothing makes the output " + in_quotes(name)});
    const Constant& constant = found->second;
    auto& buffer = pass.constants_[name];
    buffer.resize(constant.size());
    for (std::size_t i = 0; i < constant.size(); ++i) buffer.data()[i] = static_cast<T>(constant.at(i));
    pass.outputs_.push_back({buffer.data(), constant.shape, constant.type});
  }
}

template <std::floating_point T>
void StagedNetwork<T>::adjoint(StagedPass<T>& pass, const std::vector<const T*>& output_adjoints,
                               const std::vector<T*>& inputs_adjoint,
                               const std::vector<T*>& outputs_gathered) const {
  std::map<std::string, Buffer<T>> sums;
  const auto sum_of = [&](const std::string& name) {
    const auto [sum, is_new] = sums.try_emplace(name, size_of(pass.known_.at(name).shape));
    if (is_new) sum->second.fill_zero();
    return sum->second.data();
  };
  for (std::size_t i = 0; i < outputs_.size(); ++i) {
    if (output_adjoints.at(i) == nullptr || !pass.known_.contains(outputs_[i])) continue;
    T* const sum = sum_of(outputs_[i]);
    for (std::size_t k = 0; k < size_of(pass.outputs_[i].shape); ++k) sum[k] += output_adjoints[i][k];
  }
  for (auto run = pass.runs_.rbegin(); run != pass.runs_.rend(); ++run) {
    const Stage& stage = *(*run)->stage;
    if (!stage.network) continue;
    std::vector<const T*> results;
    std::vector<T*> gathered(stage.outputs.size(), nullptr);
    for (std::size_t i = 0; i < stage.outputs.size(); ++i) {
      const auto sum = sums.find(stage.outputs[i]);
      const bool is_there = stage.types[i] == ElementType::floating && sum != sums.end();
      results.push_back(is_there ? sum->second.data() : nullptr);
      for (std::size_t k = 0; k < outputs_gathered.size(); ++k)
        if (outputs_gathered[k] != nullptr && outputs_[k] == stage.outputs[i])
          gathered[i] = outputs_gathered[k];
    }
    if (std::ranges::all_of(results, [](const T* result) { return result == nullptr; })) continue;
    std::vector<T*> goals;
    for (const std::string& name : stage.inputs) goals.push_back(sum_of(name));
    stage.network->adjoint((*run)->pass, results, goals, nullptr, gathered);
  }
  for (std::size_t i = 0; i < inputs_.size(); ++i) {
    const auto sum = sums.find(inputs_[i].name);
    if (sum == sums.end() || inputs_adjoint.at(i) == nullptr) continue;
    for (std::size_t k = 0; k < sum->second.size(); ++k) inputs_adjoint[i][k] += sum->second.data()[k];
  }
}
}  // namespace tapestry::nn

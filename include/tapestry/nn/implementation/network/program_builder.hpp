#pragma once
#include <tapestry/nn/implementation/network/fold.hpp>
#include <tapestry/nn/network/program_builder.hpp>

namespace tapestry::nn {
template <std::floating_point T>
ProgramBuilder<T>::ProgramBuilder(const NetworkDescription& description,
                                  const std::map<std::string, Shape>& shapes, bool pictures_channels_last,
                                  bool stores_constants, PlanBudget budget)
    : description_(description), stores_constants_(stores_constants), budget_(std::move(budget)) {
  repeated_before_.swap(budget_.repeated);
  std::size_t elements = readable_past_end;
  for (const auto& [name, constant] : description.constants) {
    require_room_for("constant", name, constant.shape);
    known_[name].constant = &constant;
    elements += constant.size();
  }
  for (const InputDescription& input : description.inputs)
    require_room_for("input", input.name, shapes.at(input.name));
  if (!std::exchange(budget_.is_begun, true)) {
    budget_.folded += 4 * elements;
    budget_.values += 4096 * elements;
    for (const InputDescription& input : description.inputs)
      budget_.values += 4096 * size_of(shapes.at(input.name));
  }
  if (stores_constants_) program_.constants.reserve(elements);  // growing would take them twice
  for (const InputDescription& input : description.inputs) {
    Known& known = known_[input.name];
    known.shape = shapes.at(input.name);
    known.type = input.type;
    const bool is_last = pictures_channels_last && known.shape.size() == 4;
    known.value[is_last ? 1 : 0] = add_value(input.name, known.shape, input.type, is_last);
    program_.inputs.push_back(known.value[is_last ? 1 : 0]);
  }
}

template <std::floating_point T>
Program<T> ProgramBuilder<T>::build() {
  add_nodes();
  require_no_problems();
  for (const std::string& name : description_.outputs)
    if (!known_.contains(name))
      throw file_mismatch({description_.path, "", "nothing makes the output " + in_quotes(name)});
  for (const std::string& name : description_.outputs)
    program_.outputs.push_back(value_of(name, known_.at(name), false, shape_of(known_.at(name)).size()));
  if (stores_constants_) put_weights_first();
  program_.constants.resize(program_.constants.size() + readable_past_end, T(0));
  program_.path = description_.path;
  return std::move(program_);
}

template <std::floating_point T>
NetworkFacts ProgramBuilder<T>::facts() const {
  NetworkFacts facts;
  for (const auto& [name, known] : known_)
    if (!known.failed) facts[name] = {shape_of(known), known.type, known.constant};
  return facts;
}

template <std::floating_point T>
void ProgramBuilder<T>::require_room_for(const char* kind, const std::string& name,
                                         const Shape& shape) const {
  try {
    require_room(shape);
  } catch (const ShapeError& error) {
    throw FileError(ErrorKind::limit,
                    {description_.path, "", std::string(kind) + " " + in_quotes(name) + ": " + error.what()});
  }
}

template <std::floating_point T>
std::size_t ProgramBuilder<T>::add_value(const std::string& name, const Shape& logical, ElementType type,
                                         bool is_last) {
  program_.values.push_back({is_last ? stored_shape(logical) : logical, type, is_last, no_value, name});
  return program_.values.size() - 1;
}

template <std::floating_point T>
void ProgramBuilder<T>::add_node(const Node& node) {
  bool all_constant = true;
  for (const std::string& input : node.inputs) {
    if (input.empty()) continue;
    const auto known = known_.find(input);
    if (known == known_.end()) {
      add_problem(label_of(node) + ": nothing makes its input " + in_quotes(input));
      return fail(node);
    }
    if (known->second.failed) return fail(node);
    all_constant = all_constant && known->second.constant != nullptr;
  }
  try {
    if (const auto parts = decompositions().find(node.operation);
        parts != decompositions().end() && take_apart(node, parts->second))
      return;
    const bool asks_extents = node.operation == "Shape" || node.operation == "Size";
    const auto found = operators<T>().find(node.operation);
    if (!asks_extents && found == operators<T>().end()) throw DomainError("the operator is not supported");
    if (all_constant || asks_extents) return fold(node);
    make(node, found->second);
  } catch (const Error& error) {
    const std::string problem = label_of_part(node) + ": " + error.what();
    if (error.kind() == ErrorKind::limit) throw FileError(ErrorKind::limit, {description_.path, "", problem});
    add_problem(problem);
    fail(node);
  }
}

template <std::floating_point T>
void ProgramBuilder<T>::add_problem(const std::string& problem) {
  constexpr std::size_t most = 64, longest = 2000;
  if (problem_count_++ < most) problems_ += (problems_.empty() ? "" : "; ") + problem.substr(0, longest);
  if (problem_count_ == most + 1) problems_ += "; …";
}

template <std::floating_point T>
void ProgramBuilder<T>::fold(const Node& node) {
  std::vector<FoldOperand> operands;
  for (const std::string& input : node.inputs) {
    if (input.empty()) {
      operands.push_back({});
      continue;
    }
    const Known& known = known_.at(input);
    operands.push_back({known.constant, shape_of(known), true});
  }
  auto results = fold_node<T>(node, description_.opset, operands, budget_.folded);
  for (const Constant& result : results) budget_.folded -= std::min(budget_.folded, result.size());
  for (std::size_t i = 0; i < node.outputs.size(); ++i) {
    if (node.outputs[i].empty()) continue;
    require_result(i, results.size());
    folded_.push_back(std::make_unique<Constant>(std::move(results[i])));
    Known& known = known_[node.outputs[i]];
    known.constant = folded_.back().get();
    const bool is_moved = detail::moved_operands(node) == 1 &&
                          known.constant->type == ElementType::floating &&
                          operands.front().constant->type == ElementType::floating;
    known.moved_by = is_moved ? &node : nullptr;
    known.moved_result = i;
  }
}

template <std::floating_point T>
bool ProgramBuilder<T>::wants_channels_last(const Node& node, const Operator<T>& kind) const {
  if (kind.layout == LayoutRule::plain) return false;
  bool has_four = false, has_last = false, fits = true;
  for (std::size_t i = 0; i < std::min(kind.data_inputs, node.inputs.size()); ++i) {
    if (node.inputs[i].empty()) continue;
    const Known& known = known_.at(node.inputs[i]);
    const std::size_t rank = shape_of(known).size();
    has_four = has_four || rank == 4;
    fits = fits && (rank == 4 || (kind.broadcasts && rank < 4));
    has_last = has_last || (known.constant == nullptr && known.value[1] != no_value);
  }
  return has_four && fits && (kind.layout == LayoutRule::channels_last || has_last);
}

template <std::floating_point T>
void ProgramBuilder<T>::make(const Node& node, const Operator<T>& kind) {
  const bool is_last = wants_channels_last(node, kind);
  std::vector<Operand> operands;
  for (std::size_t i = 0; i < node.inputs.size(); ++i)
    operands.push_back(operand_of(node.inputs[i], is_last && i < kind.data_inputs));
  OperatorContext context(node, description_.opset, std::move(operands), is_last);
  ProgramStep<T> step{made_operation(kind, context), {}, {}, label_of(node)};
  for (std::size_t i = 0; i < node.inputs.size(); ++i) {
    const std::string& input = node.inputs[i];
    const bool is_data = is_last && i < kind.data_inputs;
    step.inputs.push_back(input.empty() ? no_value
                                        : value_of(input, known_.at(input), is_data, is_data ? 4 : 0));
  }
  if (is_repeated_) take_repeated(node, *step.operation);
  for (const auto& result : step.operation->results())
    budget_.take(&PlanBudget::values, size_of(result.shape), "elements of results");
  note_weights(step);
  for (std::size_t i = 0; i < node.outputs.size(); ++i) add_output(node.outputs[i], i, is_last, step);
  program_.steps.push_back(std::move(step));
}

template <std::floating_point T>
void ProgramBuilder<T>::add_output(const std::string& name, std::size_t i, bool is_last,
                                   ProgramStep<T>& step) {
  const auto& results = step.operation->results();
  if (i >= results.size()) {
    if (name.empty()) return;
    require_result(i, results.size());
  }
  const bool is_channels_last = is_last && results[i].shape.size() == 4;
  const Shape logical = is_channels_last ? logical_shape(results[i].shape) : results[i].shape;
  const std::size_t value = add_value(name, logical, results[i].type, is_channels_last);
  step.outputs.push_back(value);
  if (name.empty()) return;
  Known& known = known_[name];
  known.shape = logical;
  known.type = results[i].type;
  known.value[is_channels_last ? 1 : 0] = value;
}

template <std::floating_point T>
void ProgramBuilder<T>::note_weights(const ProgramStep<T>& step) {
  for (std::size_t i = 0; i < step.inputs.size(); ++i) {
    if (step.inputs[i] == no_value || !step.operation->is_weight(i)) continue;
    const ProgramValue& value = program_.values[step.inputs[i]];
    if (value.is_constant() && noted_.insert(step.inputs[i]).second)
      program_.weights.push_back(block_of(value));
  }
}

template <std::floating_point T>
void ProgramBuilder<T>::put_weights_first() {
  const auto begin = program_.constants.begin();
  std::vector<T> others;  // few beside the weights, which move in place
  std::vector<ProgramValue*> of_others;
  std::map<std::size_t, std::size_t> moved;
  for (std::size_t v = 0; v < program_.values.size(); ++v) {
    ProgramValue& value = program_.values[v];
    if (!value.is_constant()) continue;
    const auto first = begin + static_cast<std::ptrdiff_t>(value.constant);
    const auto last = first + static_cast<std::ptrdiff_t>(size_of(value.shape));
    if (noted_.contains(v)) {
      moved[value.constant] = program_.weight_count;
      if (value.constant != program_.weight_count)
        std::copy(first, last, begin + static_cast<std::ptrdiff_t>(program_.weight_count));
      value.constant = program_.weight_count;
      program_.weight_count += size_of(value.shape);
    } else {
      of_others.push_back(&value);
      value.constant = others.size();
      others.insert(others.end(), first, last);
    }
  }
  for (WeightBlock& weight : program_.weights) weight.offset = moved.at(weight.offset);
  for (ProgramValue* const value : of_others) value->constant += program_.weight_count;
  std::ranges::copy(others, begin + static_cast<std::ptrdiff_t>(program_.weight_count));
}

template <std::floating_point T>
Operand ProgramBuilder<T>::operand_of(const std::string& name, bool is_last) {
  if (name.empty()) return {};
  const Known& known = known_.at(name);
  if (known.constant == nullptr) {
    const Shape padded = is_last ? padded_shape(known.shape) : known.shape;
    return {is_last ? stored_shape(padded) : padded, known.type, nullptr, true};
  }
  const Constant* stored = is_last ? stored_constant(name, *known.constant) : known.constant;
  return {stored->shape, stored->type, stored, true};
}

template <std::floating_point T>
const Constant* ProgramBuilder<T>::stored_constant(const std::string& name, const Constant& constant) {
  auto& stored = stored_[name];
  if (!stored) stored = std::make_unique<Constant>(to_channels_last(constant));
  return stored.get();
}

template <std::floating_point T>
std::size_t ProgramBuilder<T>::value_of(const std::string& name, Known& known, bool is_last,
                                        std::size_t rank) {
  std::size_t& value = known.value[is_last ? 1 : 0];
  if (value != no_value) return value;
  if (known.constant != nullptr) {
    const Constant& constant = is_last ? *stored_constant(name, *known.constant) : *known.constant;
    value = add_value(name, constant.shape, constant.type, false);
    program_.values[value].channels_last = is_last;
    program_.values[value].constant = program_.constants.size();
    if (!stores_constants_) return value;
    std::visit([&](const auto& values) { append(values, program_.constants); }, constant.values);
    return value;
  }
  const std::size_t from = known.value[is_last ? 0 : 1];
  const Shape logical = rank == 4 ? padded_shape(known.shape) : known.shape;
  value = add_value(name, logical, known.type, is_last);
  program_.steps.push_back({std::make_unique<LayoutConversion<T>>(logical, known.type, is_last),
                            {from},
                            {value},
                            "layout of \"" + name + "\""});
  return value;
}

template <std::floating_point T>
void ProgramBuilder<T>::refuse() const {
  throw file_mismatch({description_.path, "",
                       std::to_string(problem_count_) + " node" + (problem_count_ == 1 ? "" : "s") +
                           " cannot be run: " + problems_});
}
}  // namespace tapestry::nn

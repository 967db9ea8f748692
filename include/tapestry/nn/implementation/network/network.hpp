#pragma once
#include <tapestry/nn/detail/network/simplify/fold_into_convolution.hpp>
#include <tapestry/nn/detail/network/simplify/merge_views.hpp>
#include <tapestry/nn/detail/network/tangent_network.hpp>
#include <tapestry/nn/implementation/network/fold.hpp>
#include <tapestry/nn/network/network.hpp>

namespace tapestry::nn {
namespace detail {
/// Calls body(constant, value) for those constants of numbers that a program has as its description has them.
template <std::floating_point T, class Body>
void for_each_shared(const Program<T>& program, NetworkDescription& description, const Body& body) {
  for (const ProgramValue& value : program.values)
    if (const auto found = description.constants.find(value.name);
        value.is_constant() && !value.channels_last && found != description.constants.end() &&
        found->second.type == ElementType::floating)
      body(found->second, value);
}

/// Hands a description to its program, which keeps those constants' values alone, and owns the others.
template <std::floating_point T>
void keep_description(NetworkDescription&& description, Program<T>& program) {
  for_each_shared(program, description,
                  [](Constant& constant, const ProgramValue&) { constant.values = std::vector<float>{}; });
  for (auto& [name, constant] : description.constants) {
    const auto* const borrowed = std::get_if<BorrowedValues>(&constant.values);
    if (borrowed == nullptr) continue;
    std::vector<float> own;
    append(*borrowed, own);
    constant.values = std::move(own);
  }
  program.description = std::move(description);
}

/// Copies constants of the same names, so that set_weights() counts for both.
template <std::floating_point T>
void copy_constants(const Program<T>& from, Program<T>& to) {
  std::map<std::pair<std::string, bool>, std::size_t> places;
  for (const ProgramValue& value : from.values)
    if (value.is_constant()) places[{value.name, value.channels_last}] = value.constant;
  for (const ProgramValue& value : to.values)
    if (const auto found = places.find({value.name, value.channels_last});
        value.is_constant() && found != places.end())
      std::copy_n(from.constants.data() + found->second, size_of(value.shape),
                  to.constants.data() + value.constant);
}
}  // namespace detail

template <std::floating_point T>
void Network<T>::set_weights(std::span<const T> weights) {
  if (weights.size() != program_.weight_count)
    throw ShapeError({"Network: weights is [", weights.size(), "], expected [", program_.weight_count, "]"});
  std::ranges::copy(weights, program_.constants.begin());  // in place: passes point to them
  prepare();
}

template <std::floating_point T>
std::vector<std::size_t> Network<T>::places_of(const WeightBlock& block) {
  constexpr std::size_t most = std::size_t(1) << 24U;  // places that are exact in float
  std::vector<double> places(size_of(block.constant_shape));
  if (!block.moves.empty() && places.size() > most)
    throw DomainError({"weights ", in_quotes(block.name), " are moved, and more than ", most});
  for (std::size_t i = 0; i < places.size(); ++i) places[i] = static_cast<double>(i);
  Constant moved{block.constant_shape, ElementType::floating, std::move(places)};
  for (const WeightMove& move : block.moves) {
    std::vector<FoldOperand> operands{{&moved, moved.shape, true}};
    for (std::size_t i = 0; i < move.settings.size(); ++i)
      operands.push_back({&move.settings[i], move.settings[i].shape, !move.node.inputs[i + 1].empty()});
    moved = fold_node<T>(move.node, block.opset, operands, most).at(move.result);
  }
  std::vector<std::size_t> all;
  for (std::size_t i = 0; i < moved.size(); ++i) all.push_back(static_cast<std::size_t>(moved.at(i)));
  return all;
}

template <std::floating_point T>
std::size_t Network<T>::step_of(const std::string& value) const {
  for (std::size_t s = 0; s < program_.steps.size(); ++s)
    for (const std::size_t output : program_.steps[s].outputs)
      if (output != no_value && program_.values[output].name == value) return s;
  throw DomainError({"Network::step_of: no step makes the value ", in_quotes(value)});
}

template <std::floating_point T>
void Network<T>::adjoint(NetworkPass<T>& pass, const std::vector<const T*>& output_adjoints,
                         const std::vector<T*>& inputs_adjoint, T* weights_adjoint,
                         const std::vector<T*>& outputs_gathered) const {
  pass.adjoint(program_, use_, output_adjoints, inputs_adjoint, weights_adjoint, outputs_gathered, engine_);
}

template <std::floating_point T>
Program<T> Network<T>::build(NetworkDescription&& description, const std::map<std::string, Shape>& shapes,
                             bool pictures_channels_last, bool simplifies) {
  const auto built = [&](NetworkDescription&& of) {
    Program<T> program = ProgramBuilder<T>(of, shapes, pictures_channels_last).build();
    detail::keep_description(std::move(of), program);
    return program;
  };
  if (!simplifies) return built(std::move(description));
  ProgramBuilder<T> finder(description, shapes, pictures_channels_last, false);
  static_cast<void>(finder.build());
  finder.expand(description);
  // Facts point to constants, which stay in place when this moves.
  return built(simplified(std::move(description), finder.facts(), std::is_same_v<T, float>));
}

template <std::floating_point T>
Network<T> Network<T>::with_tangents(bool of_weights) const {
  NetworkDescription description = program_.description;
  detail::for_each_shared(program_, description, [&](Constant& constant, const ProgramValue& value) {
    const T* const first = program_.constants.data() + value.constant;
    constant.values = std::vector<T>(first, first + size_of(value.shape));
  });
  std::map<std::string, Shape> shapes;
  bool is_last = false;
  for (const std::size_t input : program_.inputs) {
    const ProgramValue& value = program_.values[input];
    is_last = is_last || value.channels_last;
    shapes[value.name] = value.channels_last ? logical_shape(value.shape) : value.shape;
  }
  std::set<std::string> weights;
  for (const WeightBlock& block : program_.weights)
    if (of_weights) weights.insert(block.name);
  const auto facts_of = [&](const NetworkDescription& of, auto use) {
    ProgramBuilder<T> finder(of, shapes, is_last, false);
    static_cast<void>(finder.build());
    return use(finder);
  };
  NetworkDescription divided = facts_of(description, [&](ProgramBuilder<T>& finder) {
    finder.expand(description);
    return divided_for_tangents(description, finder.facts());
  });
  const NetworkDescription both = facts_of(divided, [&](const ProgramBuilder<T>& finder) {
    return tangent_network(std::move(divided), finder.facts(), weights);
  });
  for (std::size_t i = 0, next = input_count(); next < both.inputs.size(); ++i)
    if (both.inputs[i].type == ElementType::floating)
      shapes[both.inputs[next++].name] = shapes.at(both.inputs[i].name);
  Program<T> program = ProgramBuilder<T>(both, shapes, is_last).build();
  detail::copy_constants(program_, program);
  Network network(std::move(program));
  network.set_engine(engine_);
  return network;
}

template <std::floating_point T>
std::map<std::string, Shape> Network<T>::input_shapes(const NetworkDescription& description,
                                                      const std::map<std::string, Shape>& wanted) {
  std::map<std::string, Shape> shapes;
  for (const InputDescription& input : description.inputs) {
    if (const auto found = wanted.find(input.name); found != wanted.end()) {
      shapes.insert(*found);
      continue;
    }
    Shape shape;
    for (std::size_t axis = 0; axis < input.shape.size(); ++axis) {
      if (!input.shape[axis] && axis > 0)
        throw file_mismatch({description.path, "",
                             "input " + in_quotes(input.name) + " has an open extent at axis " +
                                 std::to_string(axis) + "; state the input's size"});
      shape.push_back(input.shape[axis].value_or(1));
    }
    shapes.emplace(input.name, std::move(shape));
  }
  return shapes;
}

template <std::floating_point T>
const Shape& Network<T>::picture_map(const char* operation) const {
  const ProgramValue* const input = input_count() == 1 ? &program_.values[program_.inputs[0]] : nullptr;
  if (input == nullptr || !map_of(*input))
    throw DomainError({operation, ": the network's input is not one picture, [1, H, W, C]"});
  return input->shape;
}

template <std::floating_point T>
void Network<T>::forward_within(const T* picture, const MapWindow& window, KeptValues<T>& kept,
                                NetworkPass<T>& pass, Mode mode) const {
  const Shape& map = picture_map("Network::forward_within");
  if (mode == Mode::training) return forward({picture}, pass, mode);
  const auto surroundings = [&] { return digest_outside(map, window, picture); };
  const bool holds = kept.plan && kept.constants.lock() == version_ && kept.mode == mode &&
                     kept.plan->picture == window && kept.plan->engine == engine_ &&
                     kept.surroundings == surroundings();
  if (!holds) {
    kept.constants.reset();  // does not hold until it is full
    kept.plan = std::make_shared<const MapWindowPlan>(
        plan_windows(program_, engine_, window, mode == Mode::input_gradient));
    kept.mode = mode;
    kept.surroundings = surroundings();
    kept.rings.clear();
    kept.rings.resize(program_.values.size());
  }
  pass.forward(program_, use_, {picture}, mode, engine_, 1, &kept, holds);
  kept.constants = version_;
}

template <std::floating_point T>
double Network<T>::share_kept(const MapWindow& window, Mode mode) const {
  static_cast<void>(picture_map("Network::share_kept"));
  return share_left_out(program_, plan_windows(program_, engine_, window, mode == Mode::input_gradient));
}

template <std::floating_point T>
void Network<T>::prepare() {
  version_ = std::make_shared<int>();
  for (ProgramStep<T>& step : program_.steps) {
    std::vector<TensorView<const T>> operands(step.inputs.size());
    for (std::size_t i = 0; i < operands.size(); ++i) {
      if (step.inputs[i] == no_value) continue;
      const ProgramValue& value = program_.values[step.inputs[i]];
      operands[i] = {&value.shape,
                     value.is_constant() ? program_.constants.data() + value.constant : nullptr};
    }
    step.operation->prepare(operands);
  }
}
}  // namespace tapestry::nn

#pragma once
#include <tapestry/nn/network/description.hpp>

namespace tapestry::nn {
/// Facts of a named value once a network's inputs have their extents.
struct ValueFacts {
  Shape shape{};
  ElementType type = ElementType::floating;
  const Constant* constant = nullptr;  ///< if it is known beforehand
};

using NetworkFacts = std::map<std::string, ValueFacts>;

/// A description that is being rewritten. Nodes keep their places, and each comes after those whose results
/// it reads. A node that replaces several stands where the last of them was.
class EditableGraph {
 public:
  static constexpr std::size_t none = static_cast<std::size_t>(-1);

  /// \param in_float  weights that are computed are kept in single precision, for a network in float
  EditableGraph(NetworkDescription description, const NetworkFacts& facts, bool in_float = false)
      : description_(std::move(description)), facts_(facts), in_float_(in_float) {
    for (std::size_t i = 0; i < size(); ++i) note_uses(i);
  }

  [[nodiscard]] std::size_t size() const { return description_.nodes.size(); }
  [[nodiscard]] const Node& node(std::size_t i) const { return description_.nodes[i]; }
  [[nodiscard]] std::int64_t opset() const { return description_.opset; }

  [[nodiscard]] bool is(std::size_t i, const char* operation) const {
    return i != none && description_.nodes[i].operation == operation;
  }
  /// The node that makes a value, or none.
  [[nodiscard]] std::size_t maker(const std::string& value) const {
    const auto found = makers_.find(value);
    return found == makers_.end() ? none : found->second;
  }
  /// The only node that reads a value, and reads it once; none if the value is a result of the network.
  [[nodiscard]] std::size_t only_reader(const std::string& value) const {
    const auto found = readers_.find(value);
    return found == readers_.end() || found->second.size() != 1 || is_result(value) ? none
                                                                                    : found->second.front();
  }
  [[nodiscard]] const std::vector<std::size_t>& readers(const std::string& value) const {
    static const std::vector<std::size_t> nobody;
    const auto found = readers_.find(value);
    return found == readers_.end() ? nobody : found->second;
  }
  [[nodiscard]] bool is_result(const std::string& value) const {
    return std::ranges::find(description_.outputs, value) != description_.outputs.end();
  }
  [[nodiscard]] const Constant* constant(const std::string& value) const {
    if (const auto own = description_.constants.find(value); own != description_.constants.end())
      return &own->second;
    const auto found = facts_.find(value);
    return found == facts_.end() ? nullptr : found->second.constant;
  }
  /// Extents of a value of the original description; null for others.
  [[nodiscard]] const Shape* shape(const std::string& value) const {
    if (const Constant* known = constant(value)) return &known->shape;
    const auto found = facts_.find(value);
    return found == facts_.end() ? nullptr : &found->second.shape;
  }
  [[nodiscard]] bool have_same_shape(const std::string& one, const std::string& other) const {
    const Shape *a = shape(one), *b = shape(other);
    return a != nullptr && b != nullptr && *a == *b;
  }

  /// Whether two values of the original description have the same element type.
  [[nodiscard]] bool have_same_type(const std::string& one, const std::string& other) const {
    if (!facts_.contains(one) || !facts_.contains(other)) return false;
    const auto type = [this](const std::string& value) {
      const Constant* const known = constant(value);
      return known != nullptr ? known->type : facts_.at(value).type;
    };
    return type(one) == type(other);
  }

  /// Puts another node in the place of node i.
  void replace(std::size_t i, Node node) {
    forget_uses(i);
    description_.nodes[i] = std::move(node);
    note_uses(i);
  }
  void remove(std::size_t i) { replace(i, Node{}); }
  /// Makes all readers of `from` read `to`.
  void redirect(const std::string& from, const std::string& to) {
    const std::vector<std::size_t> places = readers(from);
    for (const std::size_t i : places) {
      forget_uses(i);
      std::ranges::replace(description_.nodes[i].inputs, from, to);
      note_uses(i);
    }
  }
  /// Adds a constant, and returns its name: this one, made unique.
  [[nodiscard]] std::string add_constant(std::string name, Constant constant) {
    while (description_.constants.contains(name) || facts_.contains(name)) name += '\'';
    description_.constants[name] = std::move(constant);
    return name;
  }

  [[nodiscard]] bool in_float() const { return in_float_; }
  /// Frees the memory of a constant's values if no node reads it any more.
  void release(const std::string& name) {
    const auto found = description_.constants.find(name);
    if (found != description_.constants.end() && readers(name).empty() && !is_result(name))
      found->second.values = std::vector<float>{};
  }

  /// The description, without nodes and constants that are not read.
  [[nodiscard]] NetworkDescription finish() && {
    std::erase_if(description_.nodes, [&](const Node& node) {
      return std::ranges::all_of(node.outputs,
                                 [&](const auto& output) { return constant(output) != nullptr; });
    });
    const auto add_known = [&](const std::string& value) {
      const auto found = facts_.find(value);
      if (found != facts_.end() && found->second.constant != nullptr)
        description_.constants.try_emplace(value, *found->second.constant);
    };
    for (const Node& node : description_.nodes) std::ranges::for_each(node.inputs, add_known);
    std::ranges::for_each(description_.outputs, add_known);
    auto outputs = description_.outputs;
    return pruned(std::move(description_), std::move(outputs));
  }

 private:
  void note_uses(std::size_t i) {
    for (const std::string& output : node(i).outputs)
      if (!output.empty()) makers_[output] = i;
    for (const std::string& input : node(i).inputs) {
      if (input.empty()) continue;
      auto& places = readers_[input];
      places.insert(std::ranges::upper_bound(places, i), i);
    }
  }
  /// Undoes note_uses(), except for values with a newer noted node.
  void forget_uses(std::size_t i) {
    for (const std::string& output : node(i).outputs)
      if (const auto found = makers_.find(output); found != makers_.end() && found->second == i)
        makers_.erase(found);
    for (const std::string& input : node(i).inputs) {
      if (input.empty()) continue;
      auto& places = readers_[input];
      places.erase(std::ranges::lower_bound(places, i));
    }
  }

  NetworkDescription description_;
  const NetworkFacts& facts_;
  bool in_float_;
  std::map<std::string, std::size_t> makers_;
  std::map<std::string, std::vector<std::size_t>> readers_;
};

/// An attribute of a node, or its default; nothing if it is of another kind.
template <class Value>
[[nodiscard]] Value attribute_of(const Node& node, const std::string& name, Value otherwise) {
  const auto found = node.attributes.find(name);
  if (found == node.attributes.end()) return otherwise;
  const auto* value = std::get_if<Value>(&found->second);
  return value == nullptr ? otherwise : *value;
}

/// The same network with fewer nodes; its results differ in rounding only:
///
/// - copies are left out;
/// - batch normalisations and constants that scale channels are folded into the weights before them;
/// - patterns that stand for one operation become that operation: Swish, HardSwish, ChannelShuffle, padded
///   convolutions, and, for tensors stored channels last, InterleaveChannels, PixelUnshuffle and
///   FlattenPixels;
/// - convolutions apply the activation and the addition behind them (FusedConv);
/// - values that are now known beforehand become constants.
///
/// A single slope of PRelu that a convolution takes over is no longer a weight.
///
/// \param facts     of the description's values, at the extents that the network will have
/// \param in_float  weights that are computed are kept in single precision, for a network in float
[[nodiscard]] NetworkDescription simplified(NetworkDescription description, const NetworkFacts& facts,
                                            bool in_float = false);
}  // namespace tapestry::nn

#pragma once
#include <set>
#include <tapestry/core/random.hpp>
#include <tapestry/nn/network/description.hpp>

namespace tapestry::test {
/// A description that grows node by node, and the values that further nodes may read.
class RandomNetworkParts {
 public:
  explicit RandomNetworkParts(std::uint64_t seed) : random(seed) {}

  nn::NetworkDescription description{};

 protected:
  using Ints = std::vector<std::int64_t>;
  using Attributes = std::map<std::string, nn::Attribute>;

  [[nodiscard]] std::size_t one_to(std::size_t most) { return 1 + random.index(most); }
  template <class Choice>
  [[nodiscard]] Choice one_of(std::initializer_list<Choice> choices) {
    return choices.begin()[random.index(choices.size())];
  }
  static std::int64_t whole(std::size_t value) { return static_cast<std::int64_t>(value); }

  std::string input(const nn::Shape& shape) {
    const std::string name = "x" + std::to_string(description.inputs.size());
    description.inputs.push_back({name, {shape.begin(), shape.end()}});
    shapes[name] = shape;
    return name;
  }
  /// A new constant, or sometimes an old one that fits.
  std::string constant(const nn::Shape& shape, double low, double high) {
    for (const auto& [name, other] : description.constants)
      if (other.type == nn::ElementType::floating && other.shape == shape && is_within(other, low, high) &&
          random.chance(0.3))
        return name;
    std::vector<float> values(nn::size_of(shape));
    for (float& value : values) value = static_cast<float>(random.uniform(low, high));
    const std::string name = "c" + std::to_string(description.constants.size());
    description.constants[name] = {shape, nn::ElementType::floating, std::move(values)};
    return name;
  }
  static bool is_within(const nn::Constant& constant, double low, double high) {
    for (std::size_t i = 0; i < constant.size(); ++i)
      if (constant.at(i) < low || constant.at(i) > high) return false;
    return true;
  }
  std::string setting(std::vector<double> values) {
    const std::string name = "s" + std::to_string(description.constants.size());
    const std::size_t count = values.size();
    description.constants[name] = {{count}, nn::ElementType::integer, std::move(values)};
    return name;
  }
  std::string node(const char* operation, std::vector<std::string> inputs, const nn::Shape& shape,
                   Attributes attributes = {}) {
    const std::string name = "v" + std::to_string(shapes.size());
    for (const std::string& operand : inputs) read.insert(operand);
    description.nodes.push_back({"", operation, std::move(inputs), {name}, std::move(attributes)});
    shapes[name] = shape;
    return name;
  }
  [[nodiscard]] const nn::Shape& shape(const std::string& name) const { return shapes.at(name); }

  /// A value in [low, high]: a constant, or of an input that the network bends.
  std::string operand(const nn::Shape& extents, double low, double high) {
    if (random.chance(0.6)) return constant(extents, low, high);
    const double middle = (low + high) / 2, half = (high - low) / 2;
    const std::string bent = node("Tanh", {node("Neg", {input(extents)}, extents)}, extents);
    const std::string scaled = node("Mul", {bent, constant({}, half, half)}, extents);
    return middle == 0 ? scaled : node("Add", {scaled, constant({}, middle, middle)}, extents);
  }
  std::string positive(const std::string& x) {
    return node("Add", {node("Sigmoid", {x}, shape(x)), constant({}, 0.5, 0.5)}, shape(x));
  }
  std::string bounded(const std::string& x) { return node("Tanh", {x}, shape(x)); }

  /// Any picture so far, the last more often.
  std::string picture() {
    return pictures[random.chance(0.5) ? pictures.size() - 1 : random.index(pictures.size())];
  }
  void picture(const std::string& name) { pictures.push_back(name); }
  /// A value of the same extents: another one, the same, a constant, or of an input.
  std::string partner(const std::string& x) {
    std::vector<std::string> fitting;
    for (const auto& [name, extents] : shapes)
      if (extents == shape(x)) fitting.push_back(name);
    if (random.chance(0.8)) return fitting[random.index(fitting.size())];
    return operand(shape(x), -1, 1);
  }
  /// A partner, or a value that is repeated to the extents of x.
  std::string repeated(const std::string& x) {
    const nn::Shape& s = shape(x);
    switch (random.index(5)) {
      case 0:
        return operand({s[1], 1, 1}, -1, 1);
      case 1:
        return node("GlobalAveragePool", {x}, {s[0], s[1], 1, 1});
      case 2:
        return operand(one_of<nn::Shape>({{}, {1}, {s[3]}, {1, 1, s[2], 1}}), -1, 1);
      default:
        return partner(x);
    }
  }

  Random random;
  std::map<std::string, nn::Shape> shapes{};  ///< of inputs and of nodes' results
  std::set<std::string> read{};
  std::vector<std::string> pictures{};  ///< of an even number of channels, rows and columns
};
}  // namespace tapestry::test

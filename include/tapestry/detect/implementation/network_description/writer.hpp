#pragma once
#include <tapestry/nn/network/description.hpp>

namespace tapestry::detect::detail {

/// Adds nodes and constants to a description, named by the layer that they belong to.
class DescriptionWriter {
 public:
  using Attributes = std::map<std::string, nn::Attribute>;
  using Integers = std::vector<std::int64_t>;

  [[nodiscard]] static std::string name_of_layer(std::size_t i) { return "layer_" + std::to_string(i); }
  [[nodiscard]] static std::int64_t integer(std::size_t count) { return static_cast<std::int64_t>(count); }

  /// Adds a node to the layer that is being described. \returns the name of its result
  std::string add(const std::string& operation, std::vector<std::string> inputs, Attributes attributes = {}) {
    const std::string result = name_of_layer(layer_) + "." + std::to_string(network.nodes.size());
    network.nodes.push_back({result, operation, std::move(inputs), {result}, std::move(attributes)});
    return result;
  }

  std::string add_constant(const std::string& suffix, nn::Constant constant) {
    std::string name = name_of_layer(layer_) + suffix;
    while (network.constants.contains(name)) name += '\'';
    network.constants[name] = std::move(constant);
    return name;
  }
  std::string add_integers(const std::string& suffix, const Integers& integers) {
    return add_constant(
        suffix,
        {{integers.size()}, nn::ElementType::integer, std::vector<double>(integers.begin(), integers.end())});
  }
  std::string add_number(const std::string& suffix, double number) {
    return add_constant(suffix, {{}, nn::ElementType::floating, std::vector<double>{number}});
  }
  std::string slice(const std::string& input, const Integers& axes, const std::vector<std::size_t>& begins,
                    const std::vector<std::size_t>& ends, const std::vector<std::size_t>& steps) {
    const auto all = [&](const std::string& suffix, const std::vector<std::size_t>& values) {
      return add_integers(suffix, Integers(values.begin(), values.end()));
    };
    return add("Slice", {input, all(".begins", begins), all(".ends", ends), add_integers(".axes", axes),
                         all(".steps", steps)});
  }

  std::string pad(const std::string& value, Integers zeros, const Integers& after) {
    zeros.insert(zeros.end(), after.begin(), after.end());
    return add("Pad", {value, add_integers(".zeros", zeros)});
  }

  nn::NetworkDescription network{};
  std::size_t layer_ = 0;  ///< index of the layer being described
};

}  // namespace tapestry::detect::detail

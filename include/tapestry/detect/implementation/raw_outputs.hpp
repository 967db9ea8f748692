#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <tapestry/detect/raw_outputs.hpp>
#include <tapestry/nn/network/description.hpp>
#include <vector>

namespace tapestry::detect::detail {

/// Whether an operator only moves values, changes their type, or takes the logistic function of them: what
/// exports put between the last convolution and an output.
[[nodiscard]] inline bool only_presents(std::string_view operation) {
  constexpr std::array<std::string_view, 12> presenting{"Cast",     "CastLike", "Concat",    "Flatten",
                                                        "Identity", "Reshape",  "Sigmoid",   "Slice",
                                                        "Split",    "Squeeze",  "Transpose", "Unsqueeze"};
  for (const std::string_view name : presenting)
    if (name == operation) return true;
  return false;
}

}  // namespace tapestry::detect::detail

namespace tapestry::detect {

std::vector<std::string> raw_outputs(const nn::NetworkDescription& description) {
  std::map<std::string_view, const nn::Node*> makers;
  for (const nn::Node& node : description.nodes)
    for (const std::string& output : node.outputs) makers.emplace(output, &node);
  std::vector<std::string> found;
  std::set<std::string_view> seen;
  std::vector<std::string_view> waiting(description.outputs.rbegin(), description.outputs.rend());
  while (!waiting.empty()) {
    const std::string_view value = waiting.back();
    waiting.pop_back();
    const auto maker = makers.find(value);
    if (maker == makers.end() || !seen.insert(value).second) continue;
    const nn::Node& node = *maker->second;
    if (node.operation == "Conv") found.emplace_back(value);
    if (!detail::only_presents(node.operation)) continue;
    const std::size_t tensors =
        node.operation == "Concat" ? node.inputs.size() : 1;  // the others are settings
    for (std::size_t i = tensors; i-- > 0;) waiting.emplace_back(node.inputs[i]);
  }
  return found;
}

std::string common_layer(const nn::NetworkDescription& description, const std::vector<std::string>& outputs) {
  std::map<std::string, std::size_t> readers;  // of each value, raw outputs that depend on it
  for (const std::string& output : outputs) {
    std::set<std::string_view> needed{output};
    for (auto node = description.nodes.rbegin(); node != description.nodes.rend(); ++node) {
      const auto is_needed = [&](const std::string& name) { return needed.contains(name); };
      if (std::ranges::none_of(node->outputs, is_needed)) continue;
      for (const std::string& name : node->outputs)
        if (is_needed(name) && name != output) ++readers[name];
      needed.insert(node->inputs.begin(), node->inputs.end());
    }
  }
  for (auto node = description.nodes.rbegin(); node != description.nodes.rend(); ++node)
    for (const std::string& name : node->outputs)
      if (const auto found = readers.find(name); found != readers.end() && found->second == outputs.size())
        return name;
  return {};
}

}  // namespace tapestry::detect

#pragma once
#include <algorithm>
#include <set>
#include <string>
#include <tapestry/nn/network/description.hpp>
#include <tapestry/nn/network/pruned.hpp>
#include <utility>
#include <vector>

namespace tapestry::nn {

NetworkDescription pruned(NetworkDescription description, std::vector<std::string> outputs) {
  std::set<std::string> needed(outputs.begin(), outputs.end());
  std::vector<Node> kept;
  for (auto node = description.nodes.rbegin(); node != description.nodes.rend(); ++node) {
    const auto is_needed = [&](const std::string& name) { return needed.contains(name); };
    if (std::ranges::none_of(node->outputs, is_needed)) continue;
    needed.insert(node->inputs.begin(), node->inputs.end());
    kept.push_back(std::move(*node));
  }
  std::ranges::reverse(kept);
  description.nodes = std::move(kept);
  std::erase_if(description.constants,
                [&](const auto& constant) { return !needed.contains(constant.first); });
  description.outputs = std::move(outputs);
  return description;
}

}  // namespace tapestry::nn

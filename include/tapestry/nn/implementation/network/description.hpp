#pragma once
#include <algorithm>
#include <set>
#include <string_view>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/nn/detail/network/simplify/editable_graph.hpp>
#include <tapestry/nn/detail/network/simplify/fold_into_convolution.hpp>
#include <tapestry/nn/detail/network/simplify/merge_patterns.hpp>
#include <tapestry/nn/detail/network/simplify/merge_views.hpp>
#include <tapestry/nn/engine.hpp>
#include <tapestry/nn/mode.hpp>
#include <tapestry/nn/network/description.hpp>
#include <tapestry/nn/network/network.hpp>
#include <tapestry/nn/network/network_pass.hpp>
#include <tapestry/nn/network/program_builder.hpp>
#include <tapestry/nn/network/window_plan.hpp>

namespace tapestry::nn {

std::string label_of(const Node& node) {
  const std::string& name = !node.name.empty() || node.outputs.empty() ? node.name : node.outputs.front();
  return printable(std::string_view(node.operation).substr(0, 80)) + " \"" +
         printable(std::string_view(name).substr(0, 80)) + "\"";
}

const Node* maker_of(const NetworkDescription& network, const std::string& value) {
  const auto maker = std::ranges::find_if(
      network.nodes, [&](const Node& node) { return std::ranges::count(node.outputs, value) > 0; });
  return maker == network.nodes.end() ? nullptr : &*maker;
}

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

NetworkDescription simplified(NetworkDescription description, const NetworkFacts& facts, bool in_float) {
  EditableGraph graph(std::move(description), facts, in_float);
  remove_copies(graph);
  merge_patterns(graph);
  merge_views(graph);
  fold_scalings(graph);
  fuse_convolutions(graph);
  return std::move(graph).finish();
}

}  // namespace tapestry::nn

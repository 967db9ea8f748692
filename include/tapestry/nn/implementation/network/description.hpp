#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/nn/network/description.hpp>
#include <tapestry/nn/network/tensor.hpp>
#include <variant>
#include <vector>

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

}  // namespace tapestry::nn

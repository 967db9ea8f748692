#pragma once
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

}  // namespace tapestry::nn

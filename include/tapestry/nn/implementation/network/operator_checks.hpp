#pragma once
#include <tapestry/nn/detail/network/operators.hpp>

namespace tapestry::nn {

void require_operand_count(std::size_t count, std::int64_t opset, const std::vector<OperandCount>& expected) {
  OperandCount own{0, 0};
  for (const OperandCount& version : expected)
    if (version.opset <= opset) own = version;
  if (count >= own.least && count <= own.most) return;
  const std::string least = std::to_string(own.least);
  throw DomainError({count, " operands, expected ",
                     (own.most == own.least    ? least
                      : own.most == all_inputs ? "at least " + least
                                               : least + " to " + std::to_string(own.most))});
}

void require_ranges(const Node& node, const std::vector<AttributeRange>& ranges) {
  for (const AttributeRange& range : ranges) {
    const auto found = node.attributes.find(range.name);
    if (found == node.attributes.end()) continue;
    const auto require = [&](std::int64_t value) {
      if (value < range.least || value > range.most)
        throw DomainError({"attribute ", in_quotes(range.name), " is out of range: ", value, ", expected ",
                           range.least, " to ", range.most});
    };
    if (const auto* value = std::get_if<std::int64_t>(&found->second)) require(*value);
    if (const auto* values = std::get_if<std::vector<std::int64_t>>(&found->second))
      std::ranges::for_each(*values, require);
  }
}

}  // namespace tapestry::nn

#pragma once
#include <tapestry/nn/detail/network/simplify/fold_into_convolution.hpp>
#include <tapestry/nn/detail/network/simplify/merge_views.hpp>
#include <tapestry/nn/network/description.hpp>
#include <tapestry/nn/network/network.hpp>
#include <tapestry/nn/network/program_builder.hpp>

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

namespace detail {
/// Extents of all inputs as the description has them; none if one is open.
inline std::optional<std::map<std::string, Shape>> stated_inputs(const NetworkDescription& description) {
  std::map<std::string, Shape> shapes;
  for (const InputDescription& input : description.inputs) {
    Shape& shape = shapes[input.name];
    for (const std::optional<std::size_t>& extent : input.shape) {
      if (!extent) return std::nullopt;
      shape.push_back(*extent);
    }
  }
  return shapes;
}

inline std::string text_of(const std::vector<std::optional<std::size_t>>& shape) {
  return "[" + listed(shape, [](const auto& open) { return open ? std::to_string(*open) : "?"; }) + "]";
}

/// Whether a shape has the stated extents, where these are not open.
inline bool agrees(const Shape& shape, const std::vector<std::optional<std::size_t>>& stated) {
  return std::ranges::equal(shape, stated, [](std::size_t extent, const std::optional<std::size_t>& other) {
    return extent == other.value_or(extent);
  });
}

/// Names of stated_shapes that the facts contradict, outputs in front.
inline std::vector<std::string> contradicted(const NetworkDescription& description,
                                             const NetworkFacts& facts) {
  std::vector<std::string> names;
  for (const auto& [name, stated] : description.stated_shapes)
    if (const auto found = facts.find(name); found != facts.end() && !agrees(found->second.shape, stated))
      names.push_back(name);
  std::stable_partition(names.begin(), names.end(), [&](const std::string& name) {
    return std::ranges::find(description.outputs, name) != description.outputs.end();
  });
  return names;
}
}  // namespace detail

std::optional<std::string> untrue_shape(const NetworkDescription& description) try {
  const auto inputs = detail::stated_inputs(description);
  if (!inputs || description.stated_shapes.empty()) return std::nullopt;
  ProgramBuilder<float> builder(description, *inputs, false, false);
  builder.add_nodes();
  const NetworkFacts facts = builder.facts();
  const auto names = detail::contradicted(description, facts);
  if (names.empty()) return std::nullopt;
  const std::string& first = names.front();
  return description.path + ": states " + detail::text_of(description.stated_shapes.at(first)) + " for " +
         in_quotes(first) + ", which is " + tapestry::detail::to_text(facts.at(first).shape) +
         "; this is ignored" +
         (names.size() == 1
              ? ""
              : ", as are the extents of " + std::to_string(names.size() - 1) + " other values");
} catch (const FileError&) {  // inputs of these extents are refused
  return std::nullopt;
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

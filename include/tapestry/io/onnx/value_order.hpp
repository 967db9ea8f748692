#pragma once
#include <cstddef>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/io/onnx/node.hpp>
#include <tapestry/nn/network/description.hpp>
#include <vector>

namespace tapestry::io {

/// Checks that each value is made once and before it is read. Files must list nodes in such an order, so a
/// cycle shows as a node that reads what is made later.
/// Source: ONNX, docs/IR.md, Graphs.
class ValueOrder {
 public:
  /// \param description  inputs and constants are complete; it and the nodes must outlive this
  ValueOrder(const nn::NetworkDescription& description, const std::vector<PlacedNode>& nodes)
      : description_(description), nodes_(nodes) {}

  /// \throws FileError (malformed) naming the value, and the node where there is one
  void check() {
    for (const auto& [name, constant] : description_.constants) makers_.emplace(name, before_all);
    for (const nn::InputDescription& input : description_.inputs)
      if (!makers_.emplace(input.name, before_all).second) fail("two inputs " + in_quotes(input.name));
    for (std::size_t i = 0; i < nodes_.size(); ++i) add_outputs(i);
    for (std::size_t i = 0; i < nodes_.size(); ++i) check_inputs(i);
    check_graph_outputs();
  }

 private:
  static constexpr std::size_t before_all = static_cast<std::size_t>(-1);

  void add_outputs(std::size_t i) {
    for (const std::string& name : nodes_[i].node.outputs) {
      if (name.empty()) continue;
      const auto [first, is_new] = makers_.emplace(name, i);
      if (!is_new)
        fail_at(i, "makes value " + in_quotes(name) + " again",
                first->second == before_all ? "an input or initialiser" : nodes_[first->second].place);
    }
  }

  void check_inputs(std::size_t i) const {
    for (const std::string& name : nodes_[i].node.inputs) {
      if (name.empty()) continue;
      const auto maker = makers_.find(name);
      if (maker == makers_.end())
        fail_at(i, "reads value " + in_quotes(name) + ", which is no input, initialiser or output of a node",
                "");
      if (maker->second != before_all && maker->second >= i)
        fail_at(i,
                "reads value " + in_quotes(name) + " before it is made; nodes are out of order or in a cycle",
                maker->second == i ? "itself as its maker" : nodes_[maker->second].place + " as its maker");
    }
  }

  void check_graph_outputs() const {
    if (description_.outputs.empty()) fail("the graph has no outputs");
    std::set<std::string_view> seen;
    for (const std::string& name : description_.outputs) {
      if (!seen.insert(name).second) fail("two outputs " + in_quotes(name));
      if (!makers_.contains(name)) fail("output " + in_quotes(name) + " is made by no node");
    }
  }

  [[noreturn]] void fail(const std::string& what) const {
    throw FileError(ErrorKind::malformed, {description_.path, "", what});
  }
  [[noreturn]] void fail_at(std::size_t i, const std::string& what, const std::string& found) const {
    throw FileError(ErrorKind::malformed, {description_.path, "@" + std::to_string(nodes_[i].position),
                                           nodes_[i].place + ": " + what, "", found});
  }

  const nn::NetworkDescription& description_;
  const std::vector<PlacedNode>& nodes_;
  std::map<std::string_view, std::size_t> makers_{};  ///< of values, by the place of the node that makes them
};

}  // namespace tapestry::io

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

/// Checks that each value is made once, and orders nodes so that it is made before it is read. Files must
/// list nodes so, but converters to half precision append their Casts at the end.
/// Source: ONNX, docs/IR.md, Graphs.
class ValueOrder {
 public:
  /// \param description  inputs and constants are complete; it and the nodes must outlive this
  ValueOrder(const nn::NetworkDescription& description, const std::vector<PlacedNode>& nodes)
      : description_(description), nodes_(nodes) {}

  /// Places of the nodes, each behind those that make what it reads; as the file lists them where it may.
  /// \throws FileError (malformed) naming the value, and the node where there is one; for a cycle one of its
  ///         nodes
  [[nodiscard]] std::vector<std::size_t> sorted() {
    for (const auto& [name, constant] : description_.constants) makers_.emplace(name, before_all);
    for (const nn::InputDescription& input : description_.inputs)
      if (!makers_.emplace(input.name, before_all).second) fail("two inputs " + in_quotes(input.name));
    for (std::size_t i = 0; i < nodes_.size(); ++i) add_outputs(i);
    for (std::size_t i = 0; i < nodes_.size(); ++i) check_inputs(i);
    check_graph_outputs();
    return sort();
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
    }
  }

  /// Calls body(value, maker) for each operand of a node that another node makes.
  template <class Body>
  void for_each_maker(std::size_t i, Body body) const {
    for (const std::string& name : nodes_[i].node.inputs) {
      const auto maker = makers_.find(name);
      if (maker != makers_.end() && maker->second != before_all) body(name, maker->second);
    }
  }

  [[nodiscard]] std::vector<std::size_t> sort() const {
    std::vector<std::size_t> order, waits_for(nodes_.size(), 0);
    std::vector<std::vector<std::size_t>> readers(nodes_.size());
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      for_each_maker(i, [&](const std::string&, std::size_t maker) {
        ++waits_for[i];
        readers[maker].push_back(i);
      });
    std::set<std::size_t> ready;
    for (std::size_t i = 0; i < nodes_.size(); ++i)
      if (waits_for[i] == 0) ready.insert(i);
    while (!ready.empty()) {
      const std::size_t i = ready.extract(ready.begin()).value();
      order.push_back(i);
      for (const std::size_t reader : readers[i])
        if (--waits_for[reader] == 0) ready.insert(reader);
    }
    if (order.size() < nodes_.size()) refuse_cycle(waits_for);
    return order;
  }

  /// Goes back from any node that waits for others, as its makers do, until one comes again.
  [[noreturn]] void refuse_cycle(const std::vector<std::size_t>& waits_for) const {
    std::size_t i = 0;
    while (waits_for[i] == 0) ++i;
    std::set<std::size_t> seen;
    for (;;) {
      std::size_t waiting = i;
      std::string value;
      for_each_maker(i, [&](const std::string& name, std::size_t maker) {
        if (waits_for[maker] == 0) return;
        waiting = maker;
        value = name;
      });
      if (!seen.insert(i).second)
        fail_at(i, "reads value " + in_quotes(value) + ", which is made of its own results: a cycle",
                waiting == i ? "itself as its maker" : nodes_[waiting].place + " as its maker");
      i = waiting;
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

#pragma once
#include <tapestry/io/detail/onnx/subgraph.hpp>

namespace tapestry::io {
/// Checks that each value is made once, and sorts the nodes so that each value is made before it is read.
/// Files should be in this order, but converters to half precision append their Casts at the end. Source:
/// ONNX, docs/IR.md, Graphs.
class ValueOrder {
 public:
  /// \param description  inputs and constants are complete; it and the nodes must outlive this
  ValueOrder(const nn::NetworkDescription& description, const std::vector<PlacedNode>& nodes)
      : description_(description), nodes_(nodes) {}

  /// Places of the nodes, sorted so that each follows the nodes whose results it reads; keeps the
  /// file's order where possible.
  /// \throws FileError (malformed) naming the value, and the node if there is one; for a cycle one of its
  ///                   nodes
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

  /// Follows operands back from any waiting node until a node repeats: that node is on a cycle.
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
    throw malformed_file({description_.path, "", what});
  }
  [[noreturn]] void fail_at(std::size_t i, const std::string& what, const std::string& found) const {
    throw malformed_file({description_.path, "@" + std::to_string(nodes_[i].position),
                          nodes_[i].place + ": " + what, "", found});
  }

  const nn::NetworkDescription& description_;
  const std::vector<PlacedNode>& nodes_;
  std::map<std::string_view, std::size_t> makers_{};  ///< place of the node that makes a value
};

namespace detail {
class GraphReader {
 public:
  GraphReader(const ProtobufMessage& message, nn::NetworkDescription description, const OnnxLimits& limits)
      : message_(message),
        description_(std::move(description)),
        external_(description_.path, limits.external_bytes),
        records_(limits.records) {}

  [[nodiscard]] nn::NetworkDescription read() {
    ProtobufMessage message = message_;
    while (message.next()) read_field(message);
    if (nodes_.empty()) message_.fail_whole("has no nodes");
    take_inputs();
    for (const std::size_t i : ValueOrder(description_, nodes_).sorted()) {
      PlacedNode& placed = nodes_[i];
      if (placed.node.operation == "Constant") {
        const std::string name = placed.node.outputs.front();
        description_.constants.emplace(name, constant_of(placed, description_.path));
      } else {
        description_.nodes.push_back(std::move(placed.node));
      }
    }
    return std::move(description_);
  }

 private:
  void read_field(ProtobufMessage& message) {
    const auto place = [](const char* kind, std::size_t number) {
      return kind + (" " + std::to_string(number));
    };
    const std::uint32_t tag = message.tag();
    if (tag == 1 || tag == 5 || (tag >= 11 && tag <= 13)) records_.count(message);
    if (tag == 1)
      nodes_.push_back(read_node(message.message("node", place("node", nodes_.size())), external_, records_));
    if (tag == 5)
      add_initialiser(message.message("initializer", place("initialiser", description_.constants.size())),
                      external_, description_.constants);
    if (tag == 11) inputs_.push_back(message.message("input", place("input", inputs_.size())));
    if (tag == 12) {
      const auto output = message.message("output", place("output", description_.outputs.size()));
      description_.outputs.push_back(read_output(output));
      note_stated_shape(output, description_);
    }
    if (tag == 13) note_stated_shape(message.message("value_info", "value_info"), description_);
    if (tag == 15) message.fail("sparse initialisers are not supported");
  }

  /// Inputs with an initialiser are constants, because files before version 4 list all initialisers as
  /// inputs.
  void take_inputs() {
    for (const ProtobufMessage& message : inputs_) {
      nn::InputDescription input = read_input(message);
      const auto constant = description_.constants.find(input.name);
      if (constant == description_.constants.end()) {
        description_.inputs.push_back(std::move(input));
      } else if (!fits(input, constant->second)) {
        message.fail_whole(
            "input and initialiser " + in_quotes(input.name) + " differ in extents or type", "",
            tapestry::detail::to_text(constant->second.shape) + " as the initialiser's extents",
            ErrorKind::mismatch);
      }
    }
  }

  [[nodiscard]] static bool fits(const nn::InputDescription& input, const nn::Constant& constant) {
    const auto agrees = [](const auto& open, std::size_t extent) { return open.value_or(extent) == extent; };
    return input.type == constant.type && std::ranges::equal(input.shape, constant.shape, agrees);
  }

  ProtobufMessage message_;
  nn::NetworkDescription description_;
  ExternalData external_;
  OnnxRecords records_;
  std::vector<ProtobufMessage> inputs_{};
  std::vector<PlacedNode> nodes_{};
};
}  // namespace detail

/// Adds the inputs, outputs, constants and nodes of a GraphProto to the description. Initialisers and nodes
/// Constant become constants. Nodes are sorted so that each follows those whose results it reads. Texts for
/// people are left out. Source: onnx.proto, GraphProto.
///
/// \throws FileError as read_node(), read_tensor(), read_input() and ValueOrder::sorted() do; malformed for
///         a graph without nodes, initialisers given twice or kept as sparse tensors; limit
[[nodiscard]] inline nn::NetworkDescription read_graph(const ProtobufMessage& message,
                                                       nn::NetworkDescription description,
                                                       const OnnxLimits& limits) {
  return detail::GraphReader(message, std::move(description), limits).read();
}
}  // namespace tapestry::io

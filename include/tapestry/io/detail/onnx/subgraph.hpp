#pragma once
#include <set>
#include <tapestry/io/detail/onnx/node.hpp>
#include <tapestry/io/detail/onnx/value_description.hpp>

namespace tapestry::io {

namespace detail {

/// Reads a graph within a node. Its nodes are in order, as the format requires: a value that no earlier node
/// made is one of the graph around it.
class SubgraphReader {
 public:
  SubgraphReader(const ProtobufMessage& message, ExternalData& external, OnnxRecords& records)
      : message_(message), external_(external), records_(records), deeper_(records, message) {}

  [[nodiscard]] nn::Subgraph read() {
    ProtobufMessage message = message_;
    while (message.next()) read_field(message);
    known_.insert(graph_.inputs.begin(), graph_.inputs.end());
    for (const auto& [name, constant] : graph_.constants) known_.insert(name);
    for (PlacedNode& placed : nodes_) add(placed);
    for (const std::string& output : graph_.outputs) capture(output);
    if (graph_.output_types.size() != graph_.outputs.size()) graph_.output_types.clear();
    return std::move(graph_);
  }

 private:
  void read_field(ProtobufMessage& message) {
    const auto value_in = [&](const char* field) {
      records_.count(message);
      return message.message(field, message_.place() + ", " + field);
    };
    const std::uint32_t tag = message.tag();
    if (tag == 1) {
      records_.count(message);
      const std::string place = message_.place() + ", node " + std::to_string(nodes_.size());
      nodes_.push_back(read_node(message.message("node", place), external_, records_));
    }
    if (tag == 5) {
      records_.count(message);
      add_initialiser(message.message("initializer", message_.place() + ", initialiser"), external_,
                      graph_.constants);
    }
    if (tag == 11) graph_.inputs.push_back(name_within(value_in("input")));
    if (tag == 12) {
      const ProtobufMessage output = value_in("output");
      graph_.outputs.push_back(name_within(output));
      if (const auto type = stated_type(output)) graph_.output_types.push_back(*type);
    }
    if (tag == 15) message.fail("sparse initialisers are not supported");
  }

  void add(PlacedNode& placed) {
    for (const std::string& input : placed.node.inputs) capture(input);
    for (const std::string& output : placed.node.outputs)
      if (!output.empty() && !known_.insert(output).second)
        message_.fail_whole("makes value " + in_quotes(output) + " again");
    if (placed.node.operation == "Constant") {
      const std::string name = placed.node.outputs.front();
      graph_.constants.emplace(name, constant_of(placed, message_.file().path));
    } else {
      graph_.nodes.push_back(std::move(placed.node));
    }
  }

  void capture(const std::string& value) {
    if (!value.empty() && known_.insert(value).second) graph_.captured.push_back(value);
  }

  ProtobufMessage message_;
  ExternalData& external_;
  OnnxRecords& records_;
  OnnxRecords::Deeper deeper_;
  nn::Subgraph graph_{};
  std::vector<PlacedNode> nodes_{};
  std::set<std::string> known_{};
};

}  // namespace detail

inline std::shared_ptr<const nn::Subgraph> read_subgraph(const ProtobufMessage& message,
                                                         ExternalData& external, OnnxRecords& records) {
  return std::make_shared<const nn::Subgraph>(detail::SubgraphReader(message, external, records).read());
}

}  // namespace tapestry::io

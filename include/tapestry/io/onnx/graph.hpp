#pragma once
#include <cstddef>
#include <map>
#include <optional>
#include <string>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/io/onnx/external_data.hpp>
#include <tapestry/io/onnx/limits.hpp>
#include <tapestry/io/onnx/node.hpp>
#include <tapestry/io/onnx/protobuf_message.hpp>
#include <tapestry/io/onnx/tensor.hpp>
#include <tapestry/io/onnx/value_description.hpp>
#include <tapestry/io/onnx/value_order.hpp>
#include <tapestry/nn/network/description.hpp>
#include <utility>
#include <vector>

namespace tapestry::io {

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
    switch (message.tag()) {
      case 1:
        records_.count(message);
        nodes_.push_back(
            read_node(message.message("node", place("node", nodes_.size())), external_, records_));
        break;
      case 5: {
        records_.count(message);
        add_initialiser(message.message("initializer", place("initialiser", description_.constants.size())));
        break;
      }
      case 11:
        records_.count(message);
        inputs_.push_back(message.message("input", place("input", inputs_.size())));
        break;
      case 12:
        records_.count(message);
        description_.outputs.push_back(
            read_output(message.message("output", place("output", description_.outputs.size()))));
        break;
      case 15:
        message.fail("sparse initialisers are not supported");
      default:
        message.skip();
    }
  }

  void add_initialiser(const ProtobufMessage& message) {
    NamedConstant tensor = read_tensor(message, external_);
    if (tensor.name.empty()) message.fail_whole("initialiser without a name");
    if (!description_.constants.try_emplace(tensor.name, std::move(tensor.constant)).second)
      message.fail_whole("two initialisers " + in_quotes(tensor.name));
  }

  /// Inputs with an initialiser are constants: files before version 4 list all initialisers as inputs.
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
    if (input.type != constant.type || input.shape.size() != constant.shape.size()) return false;
    for (std::size_t axis = 0; axis < input.shape.size(); ++axis)
      if (input.shape[axis].value_or(constant.shape[axis]) != constant.shape[axis]) return false;
    return true;
  }

  ProtobufMessage message_;
  nn::NetworkDescription description_;
  ExternalData external_;
  OnnxRecords records_;
  std::vector<ProtobufMessage> inputs_{};
  std::vector<PlacedNode> nodes_{};
};

}  // namespace detail

/// A GraphProto: its inputs, outputs, constants and nodes are added to the description. Initialisers and
/// nodes Constant become constants; nodes are sorted so that each comes after those that it reads. What a
/// graph says of values in between, and for people, is left out.
/// Source: onnx.proto, GraphProto.
///
/// \throws FileError as read_node(), read_tensor(), read_input() and ValueOrder::sorted() do; malformed for
///         a graph without nodes, initialisers given twice or kept as sparse tensors; limit
[[nodiscard]] inline nn::NetworkDescription read_graph(const ProtobufMessage& message,
                                                       nn::NetworkDescription description,
                                                       const OnnxLimits& limits) {
  return detail::GraphReader(message, std::move(description), limits).read();
}

}  // namespace tapestry::io

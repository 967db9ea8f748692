#pragma once
#include <set>
#include <tapestry/io/detail/onnx/node.hpp>

namespace tapestry::io {
namespace detail {
/// Calls visit(ProtobufMessage) for each field with this tag, which holds a message.
template <class Visit>
void each_message(const ProtobufMessage& message, std::uint32_t tag, std::string_view field, Visit visit) {
  each_field(message, tag, [&](ProtobufMessage& at) { visit(at.message(field, at.place())); });
}

/// The name of a ValueInfoProto; it is added to its place in error messages.
[[nodiscard]] inline std::string read_value_name(ProtobufMessage& value) {
  const std::string name = text_within(value, 1, "name");
  if (name.empty()) value.fail_whole("has no name");
  value.set_place(value.place() + " " + in_quotes(name));
  return name;
}

/// A TensorShapeProto.Dimension. One that has a name or is open has no number, or −1 as Paddle writes.
/// \param least  a smaller number is refused
[[nodiscard]] inline std::optional<std::size_t> read_extent(const ProtobufMessage& message,
                                                            std::int64_t least = -1) {
  std::optional<std::size_t> extent;
  each_field(message, 1, [&](ProtobufMessage& at) {
    const std::int64_t value = at.integer("dim_value");
    if (value < least) at.fail("negative extent", "0 or more, or -1", std::to_string(value));
    if (value >= 0) extent = static_cast<std::size_t>(value);
  });
  return extent;
}

inline void read_shape(const ProtobufMessage& message, nn::InputDescription& input) {
  each_field(message, 1, [&](ProtobufMessage& at) {
    if (input.shape.size() == 32) at.fail("input has too many axes", "at most 32", "more", ErrorKind::limit);
    input.shape.push_back(read_extent(at.message("dim", at.place())));
  });
}

inline void read_tensor_type(ProtobufMessage message, nn::InputDescription& input) {
  bool has_shape = false;
  auto type = OnnxType::undefined;
  while (message.next()) {
    if (message.tag() == 1) type = static_cast<OnnxType>(message.integer("elem_type"));
    if (message.tag() != 2) continue;
    if (std::exchange(has_shape, true)) message.fail("two shapes");
    read_shape(message.message("shape", message.place()), input);
  }
  if (!is_supported(type))
    message.fail_whole("element type is not supported", supported_onnx_types, name_of(type));
  if (!has_shape) message.fail_whole("has no shape", "a number of axes, whose extents may be open");
  input.type = facts_of(type).meaning;
}

inline void read_type(ProtobufMessage message, nn::InputDescription& input) {
  bool is_tensor = false;
  while (message.next()) {
    const std::uint32_t tag = message.tag();
    if (tag == 1) {
      if (std::exchange(is_tensor, true)) message.fail("two types");
      read_tensor_type(message.message("tensor_type", message.place()), input);
    } else if (tag != 6) {  // 6: denotation
      message.fail("type is not supported", "a tensor",
                   tag == 4   ? "a sequence"
                   : tag == 5 ? "a map"
                   : tag == 8 ? "a sparse tensor"
                   : tag == 9 ? "an optional value"
                              : "type " + std::to_string(tag));
    }
  }
  if (!is_tensor) message.fail_whole("has no type", "a tensor");
}
}  // namespace detail

/// A ValueInfoProto of an input. Source: onnx.proto, ValueInfoProto, TypeProto and TensorShapeProto.
///
/// \throws FileError (malformed)  for a value without name, type or number of axes; for types other than
///         tensors of supported elements; for extents below −1; (limit) for 2^48 elements and more
[[nodiscard]] inline nn::InputDescription read_input(ProtobufMessage value) {
  nn::InputDescription input;
  input.name = detail::read_value_name(value);
  bool has_type = false;
  detail::each_field(value, 2, [&](ProtobufMessage& at) {
    if (std::exchange(has_type, true)) at.fail("two types");
    detail::read_type(at.message("type", at.place()), input);
  });
  if (!has_type) value.fail_whole("has no type", "a tensor");
  nn::Shape known;
  for (const std::optional<std::size_t>& extent : input.shape) known.push_back(extent.value_or(1));
  if (!element_count(known))
    value.fail_whole("extents are more than any memory can hold", "fewer than 2^48 elements",
                     tapestry::detail::to_text(known), ErrorKind::limit);
  return input;
}

/// The name in a ValueInfoProto of an output; its type is computed from the nodes.
/// \throws FileError (malformed)  for a value without a name
[[nodiscard]] inline std::string read_output(ProtobufMessage value) { return detail::read_value_name(value); }

/// Element type of a ValueInfoProto; none if it does not state that.
/// \throws FileError (malformed)  for bytes that are no such message
[[nodiscard]] inline std::optional<nn::ElementType> stated_type(const ProtobufMessage& value) {
  std::optional<nn::ElementType> stated;
  detail::each_message(value, 2, "type", [&](const ProtobufMessage& type) {
    detail::each_message(type, 1, "tensor_type", [&](const ProtobufMessage& tensor) {
      detail::each_field(tensor, 1, [&](ProtobufMessage& at) {
        const auto number = static_cast<OnnxType>(at.integer("elem_type"));
        if (is_supported(number)) stated = facts_of(number).meaning;
      });
    });
  });
  return stated;
}

/// Adds the extents that a ValueInfoProto states to stated_shapes, unless it states none. Nothing is computed
/// from them, so that names and extents that make no sense are left out instead of refused.
/// \throws FileError (malformed)  for bytes that are no such message
inline void note_stated_shape(const ProtobufMessage& value, nn::NetworkDescription& description) {
  const std::string name = detail::text_within(value, 1, "name");
  detail::each_message(value, 2, "type", [&](const ProtobufMessage& type) {
    detail::each_message(type, 1, "tensor_type", [&](const ProtobufMessage& tensor) {
      detail::each_message(tensor, 2, "shape", [&](const ProtobufMessage& shape) {
        auto& stated = description.stated_shapes[name];
        stated.clear();
        detail::each_message(shape, 1, "dim", [&](const ProtobufMessage& dim) {
          stated.push_back(detail::read_extent(dim, std::numeric_limits<std::int64_t>::min()));
        });
      });
    });
  });
}

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
    if (tag == 11) graph_.inputs.push_back(text_within(value_in("input"), 1, "name"));
    if (tag == 12) {
      const ProtobufMessage output = value_in("output");
      graph_.outputs.push_back(text_within(output, 1, "name"));
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

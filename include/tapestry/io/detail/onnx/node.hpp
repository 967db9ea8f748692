#pragma once
#include <tapestry/io/detail/onnx/attribute.hpp>

namespace tapestry::io {

/// A node and its place in the file.
struct PlacedNode {
  nn::Node node;
  std::uint64_t position = 0;  ///< byte of the file
  std::string place{};         ///< for messages: "node 3, Conv 'stem'"
};

/// True for the names of the domain that ONNX itself defines.
[[nodiscard]] constexpr bool is_default_domain(std::string_view domain) {
  return domain.empty() || domain == "ai.onnx";
}

namespace detail {

class NodeReader {
 public:
  NodeReader(ProtobufMessage message, ExternalData& external, OnnxRecords& records)
      : message_(std::move(message)), external_(external), records_(records) {}

  [[nodiscard]] PlacedNode read() {
    read_names();
    if (operation_.empty()) message_.fail_whole("node without an operator");
    set_operation();
    const auto is_left_out = [](const std::string& output) { return output.empty(); };
    if (std::ranges::all_of(node_.outputs, is_left_out)) message_.fail_whole("node without an output");
    read_attributes();
    for (const auto& [name, value] : node_.attributes)
      if (const auto* graph = std::get_if<std::shared_ptr<const nn::Subgraph>>(&value))
        node_.inputs.insert(node_.inputs.end(), (*graph)->captured.begin(), (*graph)->captured.end());
    return {std::move(node_), message_.position(), message_.place()};
  }

 private:
  void read_names() {
    ProtobufMessage message = message_;
    while (message.next()) {
      if (message.tag() == 1) add_name(message, "input", node_.inputs);
      if (message.tag() == 2) add_name(message, "output", node_.outputs);
      if (message.tag() == 3) node_.name = message.bytes("name");
      if (message.tag() == 4) operation_ = message.bytes("op_type");
      if (message.tag() == 7) domain_ = message.bytes("domain");
    }
  }

  void add_name(ProtobufMessage& message, std::string_view field, std::vector<std::string>& names) {
    records_.count(message);
    names.emplace_back(message.bytes(field));
  }

  void set_operation() {
    if (!is_default_domain(domain_)) node_.operation.append(domain_).append(1, '.');
    node_.operation += operation_;
    std::string place = message_.place() + ", " + printable(node_.operation.substr(0, 80));
    const bool is_named = !node_.name.empty() || node_.outputs.empty();
    message_.set_place(place + " " + in_quotes(is_named ? node_.name : node_.outputs.front()));
  }

  void read_attributes() {
    each_field(message_, 5, [&](ProtobufMessage& message) {
      records_.count(message);
      NamedAttribute attribute =
          read_attribute(message.message("attribute", message_.place()), external_, records_);
      if (!node_.attributes.try_emplace(attribute.name, std::move(attribute.value)).second)
        message_.fail_whole("two attributes " + in_quotes(attribute.name));
    });
  }

  ProtobufMessage message_;
  ExternalData& external_;
  OnnxRecords& records_;
  nn::Node node_{};
  std::string_view operation_{};
  std::string_view domain_{};
};

}  // namespace detail

/// A NodeProto. The name of an operator from another domain than ONNX's own begins with the domain:
/// "com.microsoft.Gelu".
/// Source: onnx.proto, NodeProto.
///
/// \param message its place numbers the node
/// \throws FileError  malformed for a node without operator or output and attributes given twice; as
///                    read_attribute()
[[nodiscard]] inline PlacedNode read_node(const ProtobufMessage& message, ExternalData& external,
                                          OnnxRecords& records) {
  return detail::NodeReader(message, external, records).read();
}

/// The value of a node Constant.
/// Source: ONNX, docs/Operators.md, Constant.
/// \throws FileError (malformed) unless it has exactly one of the supported attributes
[[nodiscard]] inline nn::Constant constant_of(PlacedNode& placed, const std::string& path) {
  nn::Node& node = placed.node;
  const auto fail = [&](const std::string& found) {
    throw FileError(
        ErrorKind::malformed,
        {path, "@" + std::to_string(placed.position), placed.place + ": not one constant",
         "no input, one output and one of value, value_float, value_floats, value_int, value_ints", found});
  };
  if (!node.inputs.empty()) fail("inputs");
  if (node.outputs.size() != 1) fail(std::to_string(node.outputs.size()) + " outputs");
  if (node.attributes.size() != 1) fail(std::to_string(node.attributes.size()) + " attributes");
  auto& [name, value] = *node.attributes.begin();
  constexpr auto integer = nn::ElementType::integer;
  constexpr auto floating = nn::ElementType::floating;
  if (auto* tensor = std::get_if<nn::Constant>(&value); tensor != nullptr && name == "value")
    return std::move(*tensor);
  if (const auto* number = std::get_if<double>(&value); number != nullptr && name == "value_float")
    return {{}, floating, std::vector<float>{static_cast<float>(*number)}};
  if (const auto* list = std::get_if<std::vector<double>>(&value);
      list != nullptr && name == "value_floats") {
    std::vector<float> floats;
    for (const double number : *list) floats.push_back(static_cast<float>(number));
    return {{floats.size()}, floating, std::move(floats)};
  }
  if (const auto* number = std::get_if<std::int64_t>(&value); number != nullptr && name == "value_int")
    return {{}, integer, std::vector<double>{static_cast<double>(*number)}};
  if (const auto* list = std::get_if<std::vector<std::int64_t>>(&value);
      list != nullptr && name == "value_ints")
    return {{list->size()}, integer, std::vector<double>(list->begin(), list->end())};
  fail("attribute " + in_quotes(name));
  return {};
}

}  // namespace tapestry::io

#pragma once
#include <tapestry/io/detail/onnx/tensor.hpp>
#include <tapestry/nn/network/description.hpp>

namespace tapestry::io {
/// An attribute and its name.
struct NamedAttribute {
  std::string name;
  nn::Attribute value;
};

/// A GraphProto within a node: subgraph.hpp defines it.
/// \throws FileError as read_node() and read_tensor() do; limit for graphs within graphs within graphs …
[[nodiscard]] std::shared_ptr<const nn::Subgraph> read_subgraph(const ProtobufMessage& message,
                                                                ExternalData& external, OnnxRecords& records);

namespace detail {
/// The fields of AttributeProto that hold a value, and the names of such values, by its field `type` from 1.
/// Source: onnx.proto, AttributeProto.AttributeType.
inline constexpr std::array<std::uint32_t, 14> attribute_fields{2, 3,  4,  5,  6,  7,  8,
                                                                9, 10, 11, 22, 23, 14, 15};
inline constexpr std::array<std::string_view, 14> attribute_types{
    "FLOAT",   "INT",     "STRING", "TENSOR",        "GRAPH",          "FLOATS",     "INTS",
    "STRINGS", "TENSORS", "GRAPHS", "SPARSE_TENSOR", "SPARSE_TENSORS", "TYPE_PROTO", "TYPE_PROTOS"};

class AttributeReader {
 public:
  AttributeReader(ProtobufMessage message, ExternalData& external, OnnxRecords& records)
      : message_(std::move(message)), external_(external), records_(records) {}

  [[nodiscard]] NamedAttribute read() {
    read_name_and_type();
    if (name_.empty()) message_.fail_whole("attribute without a name");
    message_.set_place(message_.place() + ", attribute " + in_quotes(name_));
    const std::uint32_t* const field = find_field();
    NamedAttribute attribute{std::string(name_), empty_value(field)};
    each_field(message_, *field, [&](ProtobufMessage& at) { read_value(at, attribute.value); });
    return attribute;
  }

 private:
  void read_name_and_type() {
    ProtobufMessage message = message_;
    while (message.next()) {
      if (message.tag() == 1) name_ = message.bytes("name");
      if (message.tag() == 20) type_ = message.integer("type");
      const auto* const field = std::ranges::find(attribute_fields, message.tag());
      if (field == attribute_fields.end()) continue;
      if (field_ != nullptr && field_ != field)
        message.fail("attribute " + in_quotes(name_) + " has two values", "one",
                     name_of(field_) + " and " + name_of(field));
      field_ = field;
    }
  }

  [[nodiscard]] static std::string name_of(const std::uint32_t* field) {
    return std::string(attribute_types[static_cast<std::size_t>(field - attribute_fields.data())]);
  }

  /// The field of the attribute. Files of the first version store no type; for those that of the value
  /// decides.
  [[nodiscard]] const std::uint32_t* find_field() const {
    if (type_ == 0 && field_ == nullptr) message_.fail_whole("has neither type nor value");
    if (type_ == 0) return field_;
    if (type_ < 1 || type_ > 14) message_.fail_whole("unknown type", "1 to 14", std::to_string(type_));
    const std::uint32_t* const field = &attribute_fields[static_cast<std::size_t>(type_ - 1)];
    if (field_ != nullptr && field_ != field)
      message_.fail_whole("value does not fit the type", name_of(field), name_of(field_));
    return field;
  }

  /// The value of a missing field: 0 for numbers, empty for texts and lists.
  [[nodiscard]] nn::Attribute empty_value(const std::uint32_t* field) const {
    if (*field == 5 && field_ == nullptr) message_.fail_whole("tensor is missing");
    if (*field == 6 && field_ == nullptr) message_.fail_whole("graph is missing");
    if (*field == 2) return 0.0;
    if (*field == 3) return std::int64_t(0);
    if (*field == 4) return std::string();
    if (*field == 5) return nn::Constant();
    if (*field == 6) return std::shared_ptr<const nn::Subgraph>();
    if (*field == 7) return std::vector<double>();
    if (*field == 8) return std::vector<std::int64_t>();
    if (*field == 9) return std::vector<std::string>();
    message_.fail_whole("attributes of this type are not supported", "", name_of(field));
  }

  void read_value(ProtobufMessage& message, nn::Attribute& value) {
    const std::uint32_t tag = message.tag();
    if (tag == 2) value = static_cast<double>(message.number("f"));
    if (tag == 3) value = message.integer("i");
    if (tag == 4) value = std::string(message.bytes("s"));
    if (tag == 5)
      value = read_tensor(message.message("t", message_.place() + ", tensor"), external_).constant;
    if (tag == 6)
      value = read_subgraph(message.message("g", message_.place() + ", graph"), external_, records_);
    if (tag == 7)
      message.each_number<float>("floats", [&list = std::get<std::vector<double>>(value)](float number) {
        list.push_back(static_cast<double>(number));
      });
    if (tag == 8)
      message.each_integer("ints", [&list = std::get<std::vector<std::int64_t>>(value)](std::int64_t number) {
        list.push_back(number);
      });
    if (tag != 9) return;
    records_.count(message);
    std::get<std::vector<std::string>>(value).emplace_back(message.bytes("strings"));
  }

  ProtobufMessage message_;
  ExternalData& external_;
  OnnxRecords& records_;
  std::string_view name_{};
  std::int64_t type_ = 0;
  const std::uint32_t* field_ = nullptr;  ///< field of the value, if there is one
};
}  // namespace detail

/// An AttributeProto: numbers become doubles. Its type may be left out, as in files of the first version.
/// Source: onnx.proto, AttributeProto.
///
/// \param message its place names the node
/// \throws FileError (malformed)  for types, sparse tensors and lists of tensors and of graphs, which are not
///         supported; for values that do not fit the type; as read_tensor() and read_subgraph()
[[nodiscard]] inline NamedAttribute read_attribute(const ProtobufMessage& message, ExternalData& external,
                                                   OnnxRecords& records) {
  return detail::AttributeReader(message, external, records).read();
}

/// A node and where it stands.
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
/// "com.microsoft.Gelu". Source: onnx.proto, NodeProto.
///
/// \param message its place numbers the node
/// \throws FileError  malformed for a node without operator or output and attributes given twice; as
///                    read_attribute()
[[nodiscard]] inline PlacedNode read_node(const ProtobufMessage& message, ExternalData& external,
                                          OnnxRecords& records) {
  return detail::NodeReader(message, external, records).read();
}

/// The value of a node Constant. Source: ONNX, docs/Operators.md, Constant.
/// \throws FileError (malformed) unless it has exactly one of the supported attributes
[[nodiscard]] inline nn::Constant constant_of(PlacedNode& placed, const std::string& path) {
  nn::Node& node = placed.node;
  const auto fail = [&](const std::string& found) {
    throw malformed_file(
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
  if (const auto* list = std::get_if<std::vector<double>>(&value); list != nullptr && name == "value_floats")
    return {{list->size()}, floating, std::vector<float>(list->begin(), list->end())};
  if (const auto* number = std::get_if<std::int64_t>(&value); number != nullptr && name == "value_int")
    return {{}, integer, std::vector<double>{static_cast<double>(*number)}};
  if (const auto* list = std::get_if<std::vector<std::int64_t>>(&value);
      list != nullptr && name == "value_ints")
    return {{list->size()}, integer, std::vector<double>(list->begin(), list->end())};
  fail("attribute " + in_quotes(name));
  return {};
}
}  // namespace tapestry::io

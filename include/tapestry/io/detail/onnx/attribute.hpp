#pragma once
#include <tapestry/io/detail/onnx/tensor.hpp>
#include <tapestry/nn/network/description.hpp>

namespace tapestry::io {

/// An attribute of a node with its name.
struct NamedAttribute {
  std::string name;
  nn::Attribute value;
};

/// A GraphProto within a node: subgraph.hpp defines it.
/// \throws FileError as read_node() and read_tensor() do; limit for graphs within graphs within graphs …
[[nodiscard]] std::shared_ptr<const nn::Subgraph> read_subgraph(const ProtobufMessage& message,
                                                                ExternalData& external, OnnxRecords& records);

namespace detail {

/// The fields of AttributeProto that hold a value, by the kinds in its field `type`.
/// Source: onnx.proto, AttributeProto.AttributeType.
struct AttributeKind {
  std::uint32_t type;
  std::uint32_t field;
  std::string_view name;
};
inline constexpr AttributeKind attribute_kinds[] = {{1, 2, "FLOAT"},
                                                    {2, 3, "INT"},
                                                    {3, 4, "STRING"},
                                                    {4, 5, "TENSOR"},
                                                    {5, 6, "GRAPH"},
                                                    {6, 7, "FLOATS"},
                                                    {7, 8, "INTS"},
                                                    {8, 9, "STRINGS"},
                                                    {9, 10, "TENSORS"},
                                                    {10, 11, "GRAPHS"},
                                                    {11, 22, "SPARSE_TENSOR"},
                                                    {12, 23, "SPARSE_TENSORS"},
                                                    {13, 14, "TYPE_PROTO"},
                                                    {14, 15, "TYPE_PROTOS"}};

class AttributeReader {
 public:
  AttributeReader(ProtobufMessage message, ExternalData& external, OnnxRecords& records)
      : message_(std::move(message)), external_(external), records_(records) {}

  [[nodiscard]] NamedAttribute read() {
    read_name_and_type();
    if (name_.empty()) message_.fail_whole("attribute without a name");
    message_.set_place(message_.place() + ", attribute " + in_quotes(name_));
    const AttributeKind& kind = find_kind();
    NamedAttribute attribute{std::string(name_), empty_value(kind)};
    each_field(message_, kind.field, [&](ProtobufMessage& at) { read_value(at, attribute.value); });
    return attribute;
  }

 private:
  void read_name_and_type() {
    ProtobufMessage message = message_;
    while (message.next()) {
      if (message.tag() == 1) name_ = message.bytes("name");
      if (message.tag() == 20) type_ = message.integer("type");
      if (const AttributeKind* kind = kind_of_field(message.tag())) add_field(message, *kind);
    }
  }

  void add_field(const ProtobufMessage& message, const AttributeKind& kind) {
    if (field_ != nullptr && field_ != &kind)
      message.fail("attribute " + in_quotes(name_) + " has two values", "one",
                   std::string(field_->name) + " and " + std::string(kind.name));
    field_ = &kind;
  }

  [[nodiscard]] static const AttributeKind* kind_of_field(std::uint32_t field) {
    for (const AttributeKind& kind : attribute_kinds)
      if (kind.field == field) return &kind;
    return nullptr;
  }

  /// The kind of the attribute. Files of the first version store no type; for those the field of the value
  /// decides.
  [[nodiscard]] const AttributeKind& find_kind() const {
    if (type_ == 0 && field_ == nullptr) message_.fail_whole("has neither type nor value");
    if (type_ == 0) return *field_;
    for (const AttributeKind& kind : attribute_kinds) {
      if (kind.type != type_) continue;
      if (field_ != nullptr && field_ != &kind)
        message_.fail_whole("value does not fit the type", std::string(kind.name), std::string(field_->name));
      return kind;
    }
    message_.fail_whole("unknown type", "1 to 14", std::to_string(type_));
  }

  /// The value of a missing field: 0 for numbers, empty for texts and lists.
  [[nodiscard]] nn::Attribute empty_value(const AttributeKind& kind) const {
    if (kind.field == 5 && field_ == nullptr) message_.fail_whole("tensor is missing");
    if (kind.field == 6 && field_ == nullptr) message_.fail_whole("graph is missing");
    if (kind.field == 2) return 0.0;
    if (kind.field == 3) return std::int64_t(0);
    if (kind.field == 4) return std::string();
    if (kind.field == 5) return nn::Constant();
    if (kind.field == 6) return std::shared_ptr<const nn::Subgraph>();
    if (kind.field == 7) return std::vector<double>();
    if (kind.field == 8) return std::vector<std::int64_t>();
    if (kind.field == 9) return std::vector<std::string>();
    message_.fail_whole("attributes of this type are not supported", "", std::string(kind.name));
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
  const AttributeKind* field_ = nullptr;  ///< field of the value, if there is one
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

}  // namespace tapestry::io

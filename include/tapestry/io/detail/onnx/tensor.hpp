#pragma once
#include <map>
#include <tapestry/io/detail/onnx/external_data.hpp>
#include <tapestry/io/detail/onnx/tensor_elements.hpp>

namespace tapestry::io {
/// A tensor of a file with its name, which may be empty.
struct NamedConstant {
  std::string name;
  nn::Constant constant;
};

namespace detail {
struct TensorFields {
  std::string_view name{};
  nn::Shape shape{};
  OnnxType type = OnnxType::undefined;
  std::uint64_t count = 0;  ///< product of the shape
  std::optional<std::string_view> raw{};
  std::uint32_t typed_field = 0;  ///< the field that holds elements, 0 if none does
  bool is_external = false;

  /// "FLOAT [2, 3]"
  [[nodiscard]] std::string kind() const { return name_of(type) + " " + tapestry::detail::to_text(shape); }
};

class TensorReader {
 public:
  /// \param message a TensorProto; its name, if any, is added to its place in error messages
  TensorReader(ProtobufMessage message, ExternalData& external)
      : message_(std::move(message)), external_(external) {}

  [[nodiscard]] NamedConstant read() {
    read_fields();
    check_fields();
    NamedConstant tensor{std::string(fields_.name), {fields_.shape, facts_of(fields_.type).meaning, {}}};
    if (tensor.constant.type == nn::ElementType::integer)
      tensor.constant.file_type = static_cast<std::int32_t>(fields_.type);
    tensor.constant.values = read_elements();
    return tensor;
  }

 private:
  void read_fields() {
    ProtobufMessage message = message_;
    while (message.next()) read_field(message);
    if (!fields_.name.empty()) message_.set_place(message_.place() + " " + in_quotes(fields_.name));
    const std::optional<std::uint64_t> count = element_count(fields_.shape);
    if (!count)
      message_.fail_whole("extents are more than any file can hold", "fewer than 2^48 elements",
                          tapestry::detail::to_text(fields_.shape), ErrorKind::limit);
    fields_.count = *count;
  }

  void read_field(ProtobufMessage& message) {
    const std::uint32_t tag = message.tag();
    if (tag == 1) message.each_integer("dims", [&](std::int64_t extent) { add_extent(message, extent); });
    if (tag == 2) fields_.type = static_cast<OnnxType>(message.integer("data_type"));
    if (tag == 3) message.fail("a tensor in segments is not supported");
    if (tag == 8) fields_.name = message.bytes("name");
    if (tag == 9) fields_.raw = message.bytes("raw_data");
    if (tag == 14) fields_.is_external = message.integer("data_location") == 1;
    if (tag == float_data || tag == int32_data || tag == int64_data || tag == double_data ||
        tag == uint64_data)
      add_typed_field(message);
  }

  void add_extent(const ProtobufMessage& message, std::int64_t extent) {
    if (extent < 0) message.fail("negative extent", "0 or more", std::to_string(extent));
    if (fields_.shape.size() == 32)
      message.fail("tensor has too many axes", "at most 32", "more", ErrorKind::limit);
    fields_.shape.push_back(static_cast<std::size_t>(extent));
  }

  void add_typed_field(const ProtobufMessage& message) {
    if (fields_.typed_field != 0 && fields_.typed_field != message.tag())
      message.fail(
          "elements in two fields", "one",
          std::string(field_name(fields_.typed_field)) + " and " + std::string(field_name(message.tag())));
    fields_.typed_field = message.tag();
  }

  void check_fields() const {
    if (!is_supported(fields_.type))
      message_.fail_whole("element type is not supported", supported_onnx_types, name_of(fields_.type));
    if (fields_.is_external) return;
    if (fields_.typed_field != 0 && fields_.raw && !fields_.raw->empty())
      message_.fail_whole("elements both in raw_data and in a field of their type", "one of them");
    if (fields_.typed_field != 0 && fields_.typed_field != facts_of(fields_.type).field)
      message_.fail_whole("elements of " + name_of(fields_.type) + " in the field of another type",
                          std::string(field_name(facts_of(fields_.type).field)),
                          std::string(field_name(fields_.typed_field)));
    const std::uint64_t size = raw_size(fields_.type, fields_.count);
    if (fields_.raw && fields_.typed_field == 0 && fields_.raw->size() != size)
      message_.fail_whole("raw_data does not fit type and extents",
                          std::to_string(size) + " bytes for " + fields_.kind(),
                          std::to_string(fields_.raw->size()));
    if (!fields_.raw && fields_.typed_field == 0 && fields_.count > 0)
      message_.fail_whole("tensor without elements", std::to_string(fields_.count) + " for " + fields_.kind(),
                          "none");
  }

  [[nodiscard]] ConstantValues read_elements() {
    const auto count = static_cast<std::size_t>(fields_.count);
    if (fields_.is_external) {
      const auto bytes = external_.read(read_reference(), raw_size(fields_.type, fields_.count), message_);
      return values_from_raw(fields_.type, bytes, count);
    }
    if (fields_.typed_field == float_data) return read_numbers<float>();
    if (fields_.typed_field == double_data) return read_numbers<double>();
    if (fields_.typed_field != 0) return read_integers();
    const std::string_view raw = fields_.raw.value_or(std::string_view());
    return values_from_raw(fields_.type, std::as_bytes(std::span<const char>(raw.data(), raw.size())), count);
  }

  [[nodiscard]] ExternalReference read_reference() const {
    ExternalReference reference;
    each_field(message_, 13, [&](ProtobufMessage& message) {
      ExternalData::read_entry(message.message("external_data", message_.place()), reference);
    });
    return reference;
  }

  template <class Number>
  [[nodiscard]] ConstantValues read_numbers() {
    std::vector<Number> values;
    each_field(message_, fields_.typed_field, [&](ProtobufMessage& message) {
      message.each_number<Number>(field_name(message.tag()), [&](Number value) { values.push_back(value); });
    });
    require_count(values.size(), fields_.count);
    return values;
  }

  /// Converts integers to the byte order of raw_data, so that one conversion serves both.
  [[nodiscard]] ConstantValues read_integers() {
    const std::size_t bits = facts_of(fields_.type).bits;
    const std::size_t item = bits < 8 ? 1 : bits / 8;
    std::vector<std::byte> bytes;
    each_field(message_, fields_.typed_field, [&](ProtobufMessage& message) {
      message.each_integer(field_name(message.tag()), [&](std::int64_t value) {
        const auto word = little_endian_bytes(static_cast<std::uint64_t>(checked(message, value)));
        bytes.insert(bytes.end(), word.begin(), word.begin() + static_cast<std::ptrdiff_t>(item));
      });
    });
    const std::uint64_t expected = bits < 8 ? (fields_.count + 1) / 2 : fields_.count;
    require_count(bytes.size() / item, expected);
    return values_from_raw(fields_.type, bytes, static_cast<std::size_t>(fields_.count));
  }

  /// Checks a value. int32_data may hold it with its sign cut to 32 bits, as protobuf reads it.
  [[nodiscard]] std::int64_t checked(const ProtobufMessage& message, std::int64_t value) const {
    if (facts_of(fields_.type).bits == 64) return value;
    if (fields_.typed_field == int32_data) value = static_cast<std::int32_t>(value);
    const IntegerRange range = facts_of(fields_.type).range;
    if (value < range.least || value > range.largest)
      message.fail("no element of " + fields_.kind(),
                   std::to_string(range.least) + " to " + std::to_string(range.largest),
                   std::to_string(value));
    return value;
  }

  void require_count(std::uint64_t found, std::uint64_t expected) const {
    if (found != expected)
      message_.fail_whole("number of elements does not fit the extents",
                          std::to_string(expected) + " for " + fields_.kind(), std::to_string(found));
  }

  ProtobufMessage message_;
  ExternalData& external_;
  TensorFields fields_{};
};

/// Adds an initialiser of a graph to its constants.
/// \throws FileError (malformed) for one without a name, or with another's name; as read_tensor()
inline void add_initialiser(const ProtobufMessage& message, ExternalData& external,
                            std::map<std::string, nn::Constant>& constants) {
  NamedConstant tensor = TensorReader(message, external).read();
  if (tensor.name.empty()) message.fail_whole("initialiser without a name");
  if (!constants.try_emplace(tensor.name, std::move(tensor.constant)).second)
    message.fail_whole("two initialisers " + in_quotes(tensor.name));
}
}  // namespace detail

/// A TensorProto: extents, type and elements. FLOAT, FLOAT16 and BFLOAT16 become floats, all other types
/// doubles. INT64 and UINT64 beyond 2^53 are rounded to the nearest double. Any Boolean but 0 is true.
/// Source: onnx.proto, TensorProto.
///
/// \throws FileError  malformed for types that are not supported, and elements that do not fit type and
///                    extents; limit for extents beyond any file; as ExternalData::read()
[[nodiscard]] inline NamedConstant read_tensor(const ProtobufMessage& message, ExternalData& external) {
  return detail::TensorReader(message, external).read();
}
}  // namespace tapestry::io

#pragma once
#include <bit>
#include <cstddef>
#include <cstdint>
#include <protozero/pbf_writer.hpp>
#include <string>
#include <utility>
#include <variant>
#include <vector>

/// Messages of ONNX files, sound or not, put together from their fields; numbers of fields as in onnx.proto.
/// Fields are joined by +: a message is the sequence of its fields.
namespace tapestry::test::onnx {
inline std::string bytes_field(std::uint32_t tag, const std::string& bytes) {
  std::string field;
  protozero::pbf_writer(field).add_bytes(tag, bytes);
  return field;
}
inline std::string integer_field(std::uint32_t tag, std::int64_t value) {
  std::string field;
  protozero::pbf_writer(field).add_int64(tag, value);
  return field;
}
inline std::string float_field(std::uint32_t tag, float value) {
  std::string field;
  protozero::pbf_writer(field).add_float(tag, value);
  return field;
}
inline std::string double_field(std::uint32_t tag, double value) {
  std::string field;
  protozero::pbf_writer(field).add_double(tag, value);
  return field;
}

/// The fields of a list: packed into one, or one each.
enum class Packing { packed, unpacked };

inline std::string integers_field(std::uint32_t tag, const std::vector<std::int64_t>& values,
                                  Packing packing = Packing::unpacked) {
  std::string field;
  protozero::pbf_writer writer(field);
  if (packing == Packing::packed) {
    writer.add_packed_int64(tag, values.begin(), values.end());
  } else {
    for (const std::int64_t value : values) writer.add_int64(tag, value);
  }
  return field;
}
inline std::string floats_field(std::uint32_t tag, const std::vector<float>& values,
                                Packing packing = Packing::unpacked) {
  std::string field;
  protozero::pbf_writer writer(field);
  if (packing == Packing::packed) {
    writer.add_packed_float(tag, values.begin(), values.end());
  } else {
    for (const float value : values) writer.add_float(tag, value);
  }
  return field;
}
inline std::string doubles_field(std::uint32_t tag, const std::vector<double>& values,
                                 Packing packing = Packing::unpacked) {
  std::string field;
  protozero::pbf_writer writer(field);
  if (packing == Packing::packed) {
    writer.add_packed_double(tag, values.begin(), values.end());
  } else {
    for (const double value : values) writer.add_double(tag, value);
  }
  return field;
}

/// The lower `size` bytes of each value, the least significant first.
inline std::string raw_integers(const std::vector<std::int64_t>& values, std::size_t size) {
  std::string bytes;
  for (const std::int64_t value : values)
    for (std::size_t i = 0; i < size; ++i)
      bytes += static_cast<char>(static_cast<std::uint64_t>(value) >> (8 * i) & 0xFFU);
  return bytes;
}
inline std::string raw_floats(const std::vector<float>& values) {
  std::vector<std::int64_t> words;
  for (const float value : values) words.push_back(std::bit_cast<std::uint32_t>(value));
  return raw_integers(words, 4);
}
inline std::string raw_doubles(const std::vector<double>& values) {
  std::vector<std::int64_t> words;
  for (const double value : values) words.push_back(std::bit_cast<std::int64_t>(value));
  return raw_integers(words, 8);
}

/// Numbers of element types.
enum Type : std::int32_t {
  float32 = 1,
  uint8 = 2,
  int8 = 3,
  uint16 = 4,
  int16 = 5,
  int32 = 6,
  int64 = 7,
  text = 8,
  boolean = 9,
  float16 = 10,
  float64 = 11,
  uint32 = 12,
  uint64 = 13,
  complex64 = 14,
  bfloat16 = 16,
  float8 = 17,
  uint4 = 21,
  int4 = 22,
};

/// A TensorProto of these fields with elements, which one of the functions above makes.
inline std::string tensor(const std::string& name, Type type, const std::vector<std::int64_t>& dims,
                          const std::string& elements, Packing packing = Packing::unpacked) {
  return integers_field(1, dims, packing) + integer_field(2, type) +
         (name.empty() ? "" : bytes_field(8, name)) + elements;
}
inline std::string float_tensor(const std::string& name, const std::vector<std::int64_t>& dims,
                                const std::vector<float>& values) {
  return tensor(name, float32, dims, bytes_field(9, raw_floats(values)));
}
inline std::string int64_tensor(const std::string& name, const std::vector<std::int64_t>& dims,
                                const std::vector<std::int64_t>& values) {
  return tensor(name, int64, dims, bytes_field(9, raw_integers(values, 8)));
}
/// The field of a TensorProto whose elements are in a file beside the model's.
inline std::string external(const std::vector<std::pair<std::string, std::string>>& entries) {
  std::string fields;
  for (const auto& [key, value] : entries)
    fields += bytes_field(13, bytes_field(1, key) + bytes_field(2, value));
  return fields + integer_field(14, 1);
}

/// An AttributeProto of a type with the field of its value.
inline std::string attribute(const std::string& name, std::int64_t type, const std::string& value) {
  return bytes_field(1, name) + value + integer_field(20, type);
}
inline std::string float_attribute(const std::string& name, float value) {
  return attribute(name, 1, float_field(2, value));
}
inline std::string int_attribute(const std::string& name, std::int64_t value) {
  return attribute(name, 2, integer_field(3, value));
}
inline std::string string_attribute(const std::string& name, const std::string& value) {
  return attribute(name, 3, bytes_field(4, value));
}
inline std::string tensor_attribute(const std::string& name, const std::string& value) {
  return attribute(name, 4, bytes_field(5, value));
}
inline std::string graph_attribute(const std::string& name, const std::string& graph) {
  return attribute(name, 5, bytes_field(6, graph));
}
inline std::string floats_attribute(const std::string& name, const std::vector<float>& values,
                                    Packing packing = Packing::unpacked) {
  return attribute(name, 6, floats_field(7, values, packing));
}
inline std::string ints_attribute(const std::string& name, const std::vector<std::int64_t>& values,
                                  Packing packing = Packing::unpacked) {
  return attribute(name, 7, integers_field(8, values, packing));
}
inline std::string strings_attribute(const std::string& name, const std::vector<std::string>& values) {
  std::string fields;
  for (const std::string& value : values) fields += bytes_field(9, value);
  return attribute(name, 8, fields);
}

/// A NodeProto; `more` is any other fields.
inline std::string node(const std::string& operation, const std::vector<std::string>& inputs,
                        const std::vector<std::string>& outputs,
                        const std::vector<std::string>& attributes = {}, const std::string& name = "",
                        const std::string& more = "") {
  std::string fields;
  for (const std::string& input : inputs) fields += bytes_field(1, input);
  for (const std::string& output : outputs) fields += bytes_field(2, output);
  if (!name.empty()) fields += bytes_field(3, name);
  if (!operation.empty()) fields += bytes_field(4, operation);
  for (const std::string& each : attributes) fields += bytes_field(5, each);
  return fields + more;
}
inline std::string domain(const std::string& name) { return bytes_field(7, name); }

/// An extent that is left open, with a number, or with a name.
using Extent = std::variant<std::monostate, std::int64_t, std::string>;

/// A ValueInfoProto of a tensor.
inline std::string value(const std::string& name, Type type, const std::vector<Extent>& extents) {
  std::string shape;
  for (const Extent& extent : extents) {
    std::string fields;
    if (const auto* number = std::get_if<std::int64_t>(&extent)) fields = integer_field(1, *number);
    if (const auto* symbol = std::get_if<std::string>(&extent)) fields = bytes_field(2, *symbol);
    shape += bytes_field(1, fields);
  }
  const std::string tensor_type = integer_field(1, type) + bytes_field(2, shape);
  return bytes_field(1, name) + bytes_field(2, bytes_field(1, tensor_type));
}

/// Parts of a ModelProto.
struct ModelParts {
  std::int64_t ir_version = 8;
  std::vector<std::pair<std::string, std::int64_t>> opsets{{"", 13}};
  std::vector<std::string> nodes{}, initialisers{}, inputs{}, outputs{};
  std::string more_of_graph{};  ///< any other fields
  std::string more_of_model{};
};

inline std::string graph(const ModelParts& parts) {
  std::string fields;
  for (const std::string& each : parts.nodes) fields += bytes_field(1, each);
  fields += bytes_field(2, "network");
  for (const std::string& each : parts.initialisers) fields += bytes_field(5, each);
  for (const std::string& each : parts.inputs) fields += bytes_field(11, each);
  for (const std::string& each : parts.outputs) fields += bytes_field(12, each);
  return fields + parts.more_of_graph;
}

inline std::string model(const ModelParts& parts) {
  std::string fields = integer_field(1, parts.ir_version) + bytes_field(2, "tests");
  fields += bytes_field(7, graph(parts));
  for (const auto& [name, version] : parts.opsets)
    fields += bytes_field(8, (name.empty() ? "" : bytes_field(1, name)) + integer_field(2, version));
  return fields + parts.more_of_model;
}

/// A picture through a convolution with a bias, an activation, and a reshape to a constant's extents.
inline ModelParts small_model() {
  ModelParts parts;
  parts.inputs = {value("picture", float32, {Extent("N"), Extent(2), Extent(3), Extent()})};
  parts.outputs = {value("logits", float32, {})};
  parts.initialisers = {float_tensor("weight", {1, 2, 1, 1}, {0.5F, -2.0F}),
                        tensor("bias", float32, {1}, floats_field(4, {0.25F}, Packing::packed))};
  parts.nodes = {
      node("Conv", {"picture", "weight", "bias"}, {"sums"},
           {ints_attribute("strides", {1, 1}), int_attribute("group", 1)}, "stem"),
      node("LeakyRelu", {"sums"}, {"activations"}, {float_attribute("alpha", 0.125F)}),
      node("Constant", {}, {"extents"}, {tensor_attribute("value", int64_tensor("", {2}, {1, -1}))}),
      node("Reshape", {"activations", "extents"}, {"logits"}, {}, "last"),
  };
  return parts;
}

/// The bytes of the small model after a change of its parts.
template <class Change>
std::string changed(Change change) {
  ModelParts parts = small_model();
  change(parts);
  return model(parts);
}
inline std::string with_tensor(const std::string& tensor) {
  return changed([&](ModelParts& parts) { parts.initialisers.push_back(tensor); });
}

/// A model of many operators, for a picture [1, 2, 3, 4].
inline ModelParts model_of_many() {
  const auto numbers = [](std::size_t count) {
    std::vector<float> values(count);
    for (std::size_t i = 0; i < count; ++i) values[i] = 0.25F + 0.125F * static_cast<float>(i % 7);
    return values;
  };
  ModelParts parts;
  parts.inputs = {value("picture", float32, {Extent(1), Extent(2), Extent(3), Extent(4)})};
  parts.outputs = {value("scores", float32, {}), value("best", float32, {})};
  parts.initialisers = {float_tensor("w", {3, 2, 3, 3}, numbers(54)),
                        float_tensor("c", {3}, numbers(3)),
                        float_tensor("slopes", {3, 1, 1}, numbers(3)),
                        int64_tensor("sizes", {4}, {1, 3, 4, 6}),
                        int64_tensor("pads", {8}, {0, 0, 0, 1, 0, 0, 1, 1}),
                        int64_tensor("zero", {1}, {0}),
                        int64_tensor("one", {1}, {1}),
                        int64_tensor("four", {1}, {4}),
                        float_tensor("v", {4, 5}, numbers(20)),
                        int64_tensor("rows", {3}, {1, -1, 4}),
                        float_tensor("u", {4, 2}, numbers(8)),
                        float_tensor("shift", {2}, numbers(2))};
  parts.nodes = {
      node("Conv", {"picture", "w", "c"}, {"sums"}, {ints_attribute("pads", {1, 1, 1, 1})}),
      node("BatchNormalization", {"sums", "c", "c", "c", "c"}, {"normal"}),
      node("PRelu", {"normal", "slopes"}, {"units"}),
      node("MaxPool", {"units"}, {"pooled"}, {ints_attribute("kernel_shape", {2, 2})}),
      node("Resize", {"pooled", "", "", "sizes"}, {"wide"}, {string_attribute("mode", "linear")}),
      node("Pad", {"units", "pads"}, {"padded"}, {string_attribute("mode", "reflect")}),
      node("Concat", {"wide", "padded"}, {"both"}, {int_attribute("axis", 1)}),
      node("Slice", {"both", "zero", "four", "one"}, {"part"}),
      node("Softmax", {"part"}, {"shares"}, {int_attribute("axis", 1)}),
      node("ReduceMean", {"shares"}, {"means"},
           {ints_attribute("axes", {2, 3}), int_attribute("keepdims", 0)}),
      node("Gemm", {"means", "v"}, {"scores"}, {float_attribute("alpha", 0.5F)}),
      node("Transpose", {"part"}, {"turned"}, {ints_attribute("perm", {0, 2, 3, 1})}),
      node("Reshape", {"turned", "rows"}, {"tokens"}),
      node("MatMul", {"tokens", "u"}, {"products"}),
      node("Add", {"products", "shift"}, {"shifted"}),
      node("Sigmoid", {"shifted"}, {"odds"}),
      node("TopK", {"odds", "one"}, {"top", "places"}, {int_attribute("axis", 1)}),
      node("Gather", {"top", "zero"}, {"best"}, {int_attribute("axis", 2)}),
  };
  return parts;
}
}  // namespace tapestry::test::onnx

#pragma once
#include <protozero/pbf_writer.hpp>
#include <tapestry/io/atomic_file.hpp>
#include <tapestry/io/detail/onnx/tensor_elements.hpp>
#include <tapestry/io/onnx/onnx_file.hpp>

namespace tapestry::io {
namespace detail {
/// Writes the messages of onnx.proto, by the numbers of their fields.
class OnnxEncoder {
 public:
  OnnxEncoder(const nn::NetworkDescription& network, const std::map<std::string, nn::Shape>& output_shapes)
      : network_(network), output_shapes_(output_shapes) {}

  [[nodiscard]] std::string model() const {
    std::string bytes;
    protozero::pbf_writer writer(bytes);
    writer.add_int64(1, network_.opset >= 19 ? 9 : 7);  // ir_version
    writer.add_string(2, "tapestry");
    writer.add_message(7, graph());
    std::string opset;
    protozero::pbf_writer(opset).add_int64(2, network_.opset);
    writer.add_message(8, opset);
    for (const auto& [key, value] : network_.metadata) {
      std::string entry;
      protozero::pbf_writer entry_writer(entry);
      entry_writer.add_string(1, key);
      entry_writer.add_string(2, value);
      writer.add_message(14, entry);
    }
    return bytes;
  }

 private:
  static constexpr std::int32_t type_float = 1, type_int64 = 7, type_bool = 9;

  [[nodiscard]] std::string graph() const {
    std::string bytes;
    protozero::pbf_writer writer(bytes);
    for (const nn::Node& node : network_.nodes)
      for (const nn::Node& standard : standard_nodes(node)) writer.add_message(1, encoded(standard));
    writer.add_string(2, "network");
    for (const auto& [name, constant] : network_.constants) writer.add_message(5, tensor(name, constant));
    for (const nn::InputDescription& input : network_.inputs)
      writer.add_message(11, value(input.name, type_of(input.type), input.shape));
    for (const std::string& output : network_.outputs) {
      const auto found = output_shapes_.find(output);
      std::optional<OpenShape> shape;
      if (found != output_shapes_.end()) shape = OpenShape(found->second.begin(), found->second.end());
      writer.add_message(12, value(output, type_float, shape));
    }
    return bytes;
  }

  [[nodiscard]] static std::int32_t type_of(nn::ElementType type) {
    if (type == nn::ElementType::integer) return type_int64;
    return type == nn::ElementType::boolean ? type_bool : type_float;
  }

  using OpenShape = std::vector<std::optional<std::size_t>>;

  /// A ValueInfoProto; without a shape, the extents stay open.
  [[nodiscard]] static std::string value(const std::string& name, std::int32_t element_type,
                                         const std::optional<OpenShape>& extents) {
    std::string shape, type, tensor, bytes;
    for (const auto& extent : extents.value_or(OpenShape{})) {
      std::string dimension;
      if (extent) protozero::pbf_writer(dimension).add_int64(1, static_cast<std::int64_t>(*extent));
      protozero::pbf_writer(shape).add_message(1, dimension);
    }
    protozero::pbf_writer(tensor).add_int32(1, element_type);
    if (extents) protozero::pbf_writer(tensor).add_message(2, shape);
    protozero::pbf_writer(type).add_message(1, tensor);
    protozero::pbf_writer writer(bytes);
    writer.add_string(1, name);
    writer.add_message(2, type);
    return bytes;
  }

  /// A node in operators of ONNX: the node itself, or several in place of HardMish,
  ///
  ///   max(x, 0) + c · (c/2 + 1),  c = min(max(x, −2), 0)
  [[nodiscard]] static std::vector<nn::Node> standard_nodes(const nn::Node& node) {
    if (node.operation != "HardMish") return {node};
    const std::string &x = node.inputs[0], &y = node.outputs[0];
    std::vector<nn::Node> nodes;
    const auto add = [&](const std::string& operation, std::vector<std::string> inputs,
                         const std::string& output, std::map<std::string, nn::Attribute> attributes = {}) {
      nodes.push_back({output, operation, std::move(inputs), {output}, std::move(attributes)});
      return output;
    };
    const auto number = [&](float value, const std::string& suffix) {
      return add("Constant", {}, y + suffix,
                 {{"value", nn::Constant{{}, nn::ElementType::floating, std::vector<float>{value}}}});
    };
    const std::string least = number(-2, ".least"), most = number(0, ".most"), half = number(0.5F, ".half"),
                      one = number(1, ".one"), c = add("Clip", {x, least, most}, y + ".clipped"),
                      line = add("Add", {add("Mul", {c, half}, y + ".halved"), one}, y + ".line");
    add("Add", {add("Relu", {x}, y + ".above"), add("Mul", {c, line}, y + ".below")}, y);
    return nodes;
  }

  [[nodiscard]] static std::string encoded(const nn::Node& node) {
    std::string bytes;
    protozero::pbf_writer writer(bytes);
    for (const std::string& input : node.inputs) writer.add_string(1, input);
    for (const std::string& output : node.outputs) writer.add_string(2, output);
    if (!node.name.empty()) writer.add_string(3, node.name);
    writer.add_string(4, node.operation);
    for (const auto& [name, attribute] : node.attributes)
      writer.add_message(5, encoded(name, written(node, name, attribute)));
    return bytes;
  }

  /// The attribute unchanged; types that a node casts to become the types that tensors are written in.
  [[nodiscard]] static nn::Attribute written(const nn::Node& node, const std::string& name,
                                             const nn::Attribute& attribute) {
    const bool is_type =
        (node.operation == "Cast" && name == "to") || (node.operation == "EyeLike" && name == "dtype");
    const auto* const number = std::get_if<std::int64_t>(&attribute);
    if (!is_type || number == nullptr || !is_supported(OnnxType(*number))) return attribute;
    return std::int64_t(type_of(facts_of(OnnxType(*number)).meaning));
  }

  [[nodiscard]] static std::string encoded(const std::string& name, const nn::Attribute& attribute) {
    constexpr std::array types{2, 1, 3, 7, 6, 4, 8};  // of AttributeProto, in the order of nn::Attribute
    if (std::holds_alternative<std::shared_ptr<const nn::Subgraph>>(attribute))
      throw DomainError("write_onnx: graphs within nodes are not supported");
    std::string bytes;
    protozero::pbf_writer writer(bytes);
    writer.add_string(1, name);
    if (const auto* number = std::get_if<double>(&attribute))
      writer.add_float(2, static_cast<float>(*number));
    if (const auto* number = std::get_if<std::int64_t>(&attribute)) writer.add_int64(3, *number);
    if (const auto* text = std::get_if<std::string>(&attribute)) writer.add_bytes(4, *text);
    if (const auto* constant = std::get_if<nn::Constant>(&attribute))
      writer.add_message(5, tensor("", *constant));
    if (const auto* list = std::get_if<std::vector<double>>(&attribute))
      for (const double value : *list) writer.add_float(7, static_cast<float>(value));
    if (const auto* list = std::get_if<std::vector<std::int64_t>>(&attribute))
      for (const std::int64_t value : *list) writer.add_int64(8, value);
    if (const auto* list = std::get_if<std::vector<std::string>>(&attribute))
      for (const std::string& value : *list) writer.add_bytes(9, value);
    writer.add_int32(20, types[attribute.index()]);
    return bytes;
  }

  /// The `size` lower bytes of a word, the lowest first.
  static void append(std::string& bytes, std::uint64_t word, std::size_t size) {
    for (std::size_t i = 0; i < size; ++i) bytes += static_cast<char>(word >> (8 * i) & 0xFFU);
  }

  /// The nearest 64-bit integer to a number read in double precision, where the largest becomes 2⁶³.
  [[nodiscard]] static std::int64_t integer_of(const std::string& name, double value) {
    if (std::isnan(value)) throw DomainError({"write_onnx: the integers of '", name, "' hold NaN"});
    if (value >= 0x1p63) return std::numeric_limits<std::int64_t>::max();
    return value < -0x1p63 ? std::numeric_limits<std::int64_t>::min() : static_cast<std::int64_t>(value);
  }

  /// The nearest number in single precision. \throws DomainError if it is infinite, and the value is not
  [[nodiscard]] static float float_of(const std::string& name, double value) {
    const auto rounded = static_cast<float>(value);
    if (std::isinf(rounded) && !std::isinf(value))
      throw DomainError({"write_onnx: '", name, "' holds ", value, ", beyond single precision"});
    return rounded;
  }

  [[nodiscard]] static std::string tensor(const std::string& name, const nn::Constant& constant) {
    const bool is_float = constant.type == nn::ElementType::floating;
    std::string bytes, elements;
    for (std::size_t i = 0; i < constant.size(); ++i) {
      const double value = constant.at(i);
      if (is_float)
        append(elements, std::bit_cast<std::uint32_t>(float_of(name, value)), 4);
      else if (constant.type == nn::ElementType::integer)
        append(elements, static_cast<std::uint64_t>(integer_of(name, value)), 8);
      else
        append(elements, value != 0 ? 1 : 0, 1);
    }
    protozero::pbf_writer writer(bytes);
    for (const std::size_t extent : constant.shape) writer.add_int64(1, static_cast<std::int64_t>(extent));
    writer.add_int32(2, type_of(constant.type));
    if (!name.empty()) writer.add_string(8, name);
    writer.add_bytes(9, elements);
    return bytes;
  }

  const nn::NetworkDescription& network_;
  const std::map<std::string, nn::Shape>& output_shapes_;
};
}  // namespace detail

std::string onnx_bytes(const nn::NetworkDescription& network,
                       const std::map<std::string, nn::Shape>& output_shapes) {
  return detail::OnnxEncoder(network, output_shapes).model();
}

void write_onnx(const std::string& path, const nn::NetworkDescription& network,
                const std::map<std::string, nn::Shape>& output_shapes) {
  write_file_atomically(path, std::string_view(onnx_bytes(network, output_shapes)));
}
}  // namespace tapestry::io

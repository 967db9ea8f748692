#pragma once
#include <tapestry/io/detail/onnx/graph.hpp>
#include <tapestry/io/onnx/onnx_file.hpp>

namespace tapestry::io {
namespace detail {
class ModelReader {
 public:
  ModelReader(const ProtobufFile& file, const OnnxLimits& limits)
      : message_(file, "the model"), limits_(limits) {}

  [[nodiscard]] nn::NetworkDescription read() {
    try {
      ProtobufMessage message = message_;
      while (message.next()) read_field(message);
    } catch (const FileError& error) {
      if (!ir_version_) refuse_format(error.details().what);
      throw;
    }
    if (!ir_version_) refuse_format("no version of the format");
    if (*ir_version_ < 3)
      message_.fail_whole("version of the format is too old", "3 or more", std::to_string(*ir_version_));
    if (!graph_) message_.fail_whole("has no graph");
    if (!opset_) message_.fail_whole("imports no version of ONNX's operators", opsets());
    if (*opset_ < first_opset || *opset_ > last_opset)
      message_.fail_whole("version of the operators is not supported", opsets(), std::to_string(*opset_));
    nn::NetworkDescription description;
    description.path = message_.file().path;
    description.opset = *opset_;
    description.metadata = std::move(metadata_);
    return read_graph(*graph_, std::move(description), limits_);
  }

 private:
  [[nodiscard]] static std::string opsets() {
    return "opset " + std::to_string(first_opset) + " to " + std::to_string(last_opset);
  }

  void read_field(ProtobufMessage& message) {
    const std::uint32_t tag = message.tag();
    if (tag == 1) ir_version_ = message.integer("ir_version");
    if (tag == 2) (void)message.bytes("producer_name");
    if (tag == 3) (void)message.bytes("producer_version");
    if (tag == 7 && graph_) message.fail("two graphs");
    if (tag == 7) graph_ = message.message("graph", "the graph");
    if (tag == 8) read_opset(message.message("opset_import", "opset_import"));
    if (tag == 14) read_metadata(message.message("metadata_props", "metadata_props"));
    if (tag == 25) check_function(message.message("functions", "functions"));
  }

  /// Reads an operator set. The highest of several versions counts, as onnx.proto requires.
  void read_opset(const ProtobufMessage& message) {
    std::int64_t version = 0;
    each_field(message, 2, [&](ProtobufMessage& at) { version = at.integer("version"); });
    if (is_default_domain(text_within(message, 1, "domain")) && (!opset_ || version > *opset_))
      opset_ = version;
  }

  void read_metadata(const ProtobufMessage& message) {
    const std::string key = text_within(message, 1, "key");
    if (!metadata_.emplace(key, text_within(message, 2, "value")).second)
      message.fail_whole("two values of the metadata " + in_quotes(key));
  }

  /// Refuses functions of ONNX's own domain: a function replaces the operator of its name, and that would go
  /// unnoticed. A function of another domain is refused where a node calls it.
  static void check_function(const ProtobufMessage& message) {
    if (is_default_domain(text_within(message, 10, "domain")))
      message.fail_whole("function " + in_quotes(text_within(message, 1, "name")) +
                         " replaces an operator, which is not supported");
  }

  [[noreturn]] void refuse_format(const std::string& why) const {
    const std::string_view bytes = message_.file().bytes;
    const std::string_view beginning = bytes.substr(0, 64);
    const std::string_view recognised =
        recognised_format(std::as_bytes(std::span<const char>(beginning.data(), beginning.size())));
    std::string found = bytes.empty() ? "0 bytes" : std::string(recognised);
    if (found.empty()) found = why;
    throw malformed_file({message_.file().path, "@0", "not an ONNX file", "a ModelProto of ONNX", found});
  }

  ProtobufMessage message_;
  const OnnxLimits& limits_;
  std::optional<std::int64_t> ir_version_{};
  std::optional<std::int64_t> opset_{};
  std::optional<ProtobufMessage> graph_{};
  std::map<std::string, std::string> metadata_{};
};

std::string_view text_of(const std::vector<std::byte>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// The elements of a tensor within the bytes of its file.
struct ElementSpan {
  std::string name{};
  OnnxType type = OnnxType::undefined;
  bool is_outside = false;   ///< in a file of its own
  std::size_t pieces = 0;    ///< number of parts that the elements are split into
  std::string_view bytes{};  ///< of the last piece
};

[[nodiscard]] inline ElementSpan element_span(ProtobufMessage tensor, const std::string& name) {
  ElementSpan span;
  while (tensor.next()) {
    if (tensor.tag() == 2) span.type = static_cast<OnnxType>(tensor.integer("data_type"));
    if (tensor.tag() == 8) span.name = tensor.bytes("name");
    if (tensor.tag() == 14) span.is_outside = tensor.integer("data_location") == 1;
    if (tensor.tag() != 9 && (tensor.tag() != float_data || !tensor.holds_bytes())) continue;
    const std::string_view bytes = tensor.bytes("elements");
    if (bytes.empty()) continue;
    span.bytes = bytes;
    ++span.pieces;
  }
  if (!name.empty()) span.name = name;
  return span;
}

/// Visits tensors within a node, with the name of its output: for a node Constant this is its value.
template <class Visit>
void visit_tensors(const ProtobufMessage& node, Visit visit) {
  const std::string name = text_within(node, 2, "output");
  each_field(node, 5, [&](ProtobufMessage& at) {
    each_field(at.message("attribute", node.place()), 5,
               [&](ProtobufMessage& attribute) { visit(attribute.message("value", node.place()), name); });
  });
}

/// \throws FileError (mismatch) unless so many floats can replace the elements
inline void require_replaceable(const ProtobufMessage& tensor, const ElementSpan& span, std::size_t count) {
  const auto refuse = [&](const std::string& expected, const std::string& found) {
    tensor.fail_whole("weights " + in_quotes(span.name) + " cannot be replaced", expected, found,
                      ErrorKind::mismatch);
  };
  if (span.type != OnnxType::float32) refuse("elements of FLOAT", name_of(span.type));
  if (span.pieces != 1) refuse("elements in one piece within the file", std::to_string(span.pieces));
  if (span.bytes.size() != count * sizeof(float))
    refuse(std::to_string(count) + " elements", std::to_string(span.bytes.size() / sizeof(float)));
}
}  // namespace detail

nn::NetworkDescription parse_onnx(std::string_view bytes, const std::string& path, const OnnxLimits& limits) {
  return detail::ModelReader(ProtobufFile{path, bytes}, limits).read();
}

nn::NetworkDescription read_onnx(const std::string& path, const OnnxLimits& limits) {
  const std::vector<std::byte> bytes = read_file(path, limits.file_bytes);
  return parse_onnx(detail::text_of(bytes), path, limits);
}

nn::Constant read_onnx_tensor(const std::string& path, const OnnxLimits& limits) {
  const std::vector<std::byte> bytes = read_file(path, limits.file_bytes);
  const ProtobufFile file{path, detail::text_of(bytes)};
  ExternalData external(path, limits.external_bytes);
  return read_tensor(ProtobufMessage(file, "tensor"), external).constant;
}

WeightValues weight_values(const nn::Network<float>& network) {
  WeightValues values;
  std::map<std::string, std::vector<bool>> is_there;  // of initialisers that nodes have moved
  for (const nn::WeightBlock& block : network.weight_blocks()) {
    const auto weights = network.weights().subspan(block.offset, nn::size_of(block.shape));
    auto& all = values[block.name];
    if (block.moves.empty()) {
      all.assign(weights.begin(), weights.end());
      continue;
    }
    const auto places = nn::Network<float>::places_of(block);
    const std::size_t count = nn::size_of(block.constant_shape);
    all.resize(count);
    auto& found = is_there[block.name];
    found.resize(count);
    for (std::size_t i = 0; i < weights.size(); ++i) {
      all[places[i]] = weights[i];
      found[places[i]] = true;
    }
  }
  for (const nn::WeightBlock& block : network.weight_blocks())
    if (block.moves.empty()) is_there.erase(block.name);  // all of it
  for (const auto& [name, found] : is_there)
    if (const auto count = std::ranges::count(found, false); count > 0)
      throw DomainError({"weights ", in_quotes(name), ": ", count, " of them are not used"});
  return values;
}

std::string with_weights(std::string_view bytes, const std::string& path, const WeightValues& weights) {
  const ProtobufFile file{path, bytes};
  std::string replaced(bytes);
  std::set<std::string> found;
  const auto replace = [&](const ProtobufMessage& tensor, const std::string& name) {
    const detail::ElementSpan span = detail::element_span(tensor, name);
    if (span.is_outside)
      tensor.fail_whole(
          "weights cannot be replaced: " + in_quotes(span.name) + " has its elements in another file",
          "all elements within the file", "", ErrorKind::mismatch);
    const auto values = weights.find(span.name);
    if (values == weights.end()) return;
    detail::require_replaceable(tensor, span, values->second.size());
    found.insert(span.name);
    auto at = replaced.begin() + (span.bytes.data() - bytes.data());
    for (const float value : values->second)
      for (const std::byte byte : little_endian_bytes(std::bit_cast<std::uint32_t>(value)))
        *at++ = static_cast<char>(byte);
  };
  detail::each_field({file, "the model"}, 7, [&](ProtobufMessage& model) {
    const ProtobufMessage graph = model.message("graph", "the graph");
    detail::each_field(graph, 5,
                       [&](ProtobufMessage& at) { replace(at.message("initializer", "initialiser"), ""); });
    detail::each_field(
        graph, 1, [&](ProtobufMessage& at) { detail::visit_tensors(at.message("node", "node"), replace); });
  });
  for (const auto& [name, values] : weights)
    if (!found.contains(name))
      throw file_mismatch({path, "", "weights " + in_quotes(name) + " cannot be replaced",
                           "an initialiser or a node Constant with a tensor", "none of that name"});
  return replaced;
}
}  // namespace tapestry::io

#pragma once
#include <cstddef>
#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/io/file_source.hpp>
#include <tapestry/io/onnx/external_data.hpp>
#include <tapestry/io/onnx/graph.hpp>
#include <tapestry/io/onnx/limits.hpp>
#include <tapestry/io/onnx/node.hpp>
#include <tapestry/io/onnx/onnx_file.hpp>
#include <tapestry/io/onnx/protobuf_message.hpp>
#include <tapestry/io/onnx/tensor.hpp>
#include <tapestry/nn/network/description.hpp>
#include <tapestry/nn/network/tensor.hpp>
#include <vector>

namespace tapestry::io::detail {

/// What a ModelProto says beside its graph.
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
    return read_graph(*graph_, std::move(description), limits_);
  }

 private:
  [[nodiscard]] static std::string opsets() {
    return "opset " + std::to_string(first_opset) + " to " + std::to_string(last_opset);
  }

  void read_field(ProtobufMessage& message) {
    switch (message.tag()) {
      case 1:
        ir_version_ = message.integer("ir_version");
        break;
      case 2:
        (void)message.bytes("producer_name");
        break;
      case 3:
        (void)message.bytes("producer_version");
        break;
      case 7:
        if (graph_) message.fail("two graphs");
        graph_ = message.message("graph", "the graph");
        break;
      case 8:
        read_opset(message.message("opset_import", "opset_import"));
        break;
      case 25:
        check_function(message.message("functions", "functions"));
        break;
      default:
        message.skip();
    }
  }

  /// Of several versions the highest counts, as onnx.proto says of opset_import.
  void read_opset(ProtobufMessage message) {
    std::string_view domain;
    std::int64_t version = 0;
    while (message.next()) {
      if (message.tag() == 1) {
        domain = message.bytes("domain");
      } else if (message.tag() == 2) {
        version = message.integer("version");
      } else {
        message.skip();
      }
    }
    if (is_default_domain(domain) && (!opset_ || version > *opset_)) opset_ = version;
  }

  /// A function replaces the operator of its name. One of another domain is refused where a node calls it;
  /// one of ONNX's own would go unnoticed.
  void check_function(ProtobufMessage message) {
    std::string_view name;
    std::string_view domain;
    while (message.next()) {
      if (message.tag() == 1) {
        name = message.bytes("name");
      } else if (message.tag() == 10) {
        domain = message.bytes("domain");
      } else {
        message.skip();
      }
    }
    if (is_default_domain(domain))
      message.fail_whole("function " + in_quotes(name) + " replaces an operator, which is not supported");
  }

  [[noreturn]] void refuse_format(const std::string& why) const {
    const std::string_view bytes = message_.file().bytes;
    const std::string_view beginning = bytes.substr(0, 64);
    const std::string_view recognised =
        recognised_format(std::as_bytes(std::span<const char>(beginning.data(), beginning.size())));
    std::string found = bytes.empty() ? "0 bytes" : std::string(recognised);
    if (found.empty()) found = why;
    throw FileError(ErrorKind::malformed,
                    {message_.file().path, "@0", "not an ONNX file", "a ModelProto of ONNX", found});
  }

  ProtobufMessage message_;
  const OnnxLimits& limits_;
  std::optional<std::int64_t> ir_version_{};
  std::optional<std::int64_t> opset_{};
  std::optional<ProtobufMessage> graph_{};
};

std::string_view text_of(const std::vector<std::byte>& bytes) {
  return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

}  // namespace tapestry::io::detail

namespace tapestry::io {

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

}  // namespace tapestry::io

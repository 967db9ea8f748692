#pragma once
#include <bit>
#include <cstddef>
#include <cstdint>
#include <map>
#include <set>
#include <string>
#include <string_view>
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/io/float_formats.hpp>
#include <tapestry/io/onnx/element_type.hpp>
#include <tapestry/io/onnx/protobuf_message.hpp>
#include <tapestry/io/onnx/weight_replacement.hpp>
#include <vector>

namespace tapestry::io::detail {

/// The elements of an initialiser where its file has them.
struct ElementSpan {
  std::string name{};
  OnnxType type = OnnxType::undefined;
  bool is_outside = false;   ///< in a file of its own
  std::size_t pieces = 0;    ///< in which the elements lie
  std::string_view bytes{};  ///< of the last piece
};

[[nodiscard]] inline ElementSpan element_span(ProtobufMessage tensor) {
  ElementSpan span;
  while (tensor.next()) {
    if (tensor.tag() == 2) {
      span.type = static_cast<OnnxType>(tensor.integer("data_type"));
    } else if (tensor.tag() == 8) {
      span.name = tensor.bytes("name");
    } else if (tensor.tag() == 14) {
      span.is_outside = tensor.integer("data_location") == 1;
    } else if (tensor.tag() == 9 || (tensor.tag() == float_data && tensor.holds_bytes())) {
      const std::string_view bytes = tensor.bytes("elements");
      if (bytes.empty()) continue;
      span.bytes = bytes;
      ++span.pieces;
    } else {
      tensor.skip();
    }
  }
  return span;
}

/// \throws FileError (mismatch) unless so many floats can take the elements' place
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

}  // namespace tapestry::io::detail

namespace tapestry::io {

WeightValues weight_values(const nn::Network<float>& network) {
  WeightValues values;
  for (const nn::WeightBlock& block : network.weight_blocks()) {
    const auto weights = network.weights().subspan(block.offset, nn::size_of(block.shape));
    values[block.name].assign(weights.begin(), weights.end());
  }
  return values;
}

std::string with_weights(std::string_view bytes, const std::string& path, const WeightValues& weights) {
  const ProtobufFile file{path, bytes};
  std::string replaced(bytes);
  std::set<std::string> found;
  const auto replace = [&](const ProtobufMessage& tensor) {
    const detail::ElementSpan span = detail::element_span(tensor);
    if (span.is_outside)
      tensor.fail_whole("weights cannot be replaced: initialiser " + in_quotes(span.name) +
                            " has its elements in another file",
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
  ProtobufMessage model(file, "the model");
  while (model.next()) {
    if (model.tag() != 7) {
      model.skip();
      continue;
    }
    ProtobufMessage graph = model.message("graph", "the graph");
    while (graph.next()) {
      if (graph.tag() == 5)
        replace(graph.message("initializer", "initialiser"));
      else
        graph.skip();
    }
  }
  for (const auto& [name, values] : weights)
    if (!found.contains(name))
      throw FileError(ErrorKind::mismatch, {path, "", "weights " + in_quotes(name) + " cannot be replaced",
                                            "an initialiser of the graph", "none of that name"});
  return replaced;
}

}  // namespace tapestry::io

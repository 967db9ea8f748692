#pragma once
#include <cstddef>
#include <cstdint>
#include <map>
#include <string>
#include <string_view>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/io/onnx/protobuf_message.hpp>
#include <tapestry/nn/network/description.hpp>
#include <tapestry/nn/network/network.hpp>
#include <tapestry/nn/network/tensor.hpp>
#include <vector>

namespace tapestry::io {

/// Versions of ONNX's operators that are understood; 7 is that of ONNX 1.2.
inline constexpr std::int64_t first_opset = 7;
inline constexpr std::int64_t last_opset = 21;

namespace detail {

[[nodiscard]] std::string_view text_of(const std::vector<std::byte>& bytes);

}  // namespace detail

/// Reads an ONNX model that is held in memory.
///
/// Nodes of ONNX's own domain, opset 7 to 21, keep the operator's name; others get that of their domain
/// before it, "com.microsoft.Gelu", so that whoever runs the network can refuse them by name. Initialisers
/// and nodes Constant become constants, also where a graph lists them as inputs. Tensors may lie in files
/// beside the model. What concerns training or people alone is left out. Source: onnx.proto and docs/IR.md of
/// ONNX.
///
/// \param path  of the file, for messages, and for finding those beside it
/// \throws FileError  with the byte and the node or tensor: malformed for what is no ONNX file, is cut or
///                    breaks its rules, and for what is not supported: other opsets, subgraphs, sparse
///                    tensors, types as texts and sequences; mismatch for parts that do not fit each other;
///                    limit beyond `limits`
[[nodiscard]] nn::NetworkDescription parse_onnx(std::string_view bytes, const std::string& path,
                                                const OnnxLimits& limits = {});

/// Reads an ONNX model from a file; see parse_onnx().
/// Takes memory of at most 56 times the file and 1 MiB.
/// \throws FileError  also as RegularFile does
[[nodiscard]] nn::NetworkDescription read_onnx(const std::string& path, const OnnxLimits& limits = {});

/// Reads a file of one tensor, as ONNX's test vectors are: a TensorProto.
/// \throws FileError  as read_tensor() and RegularFile do
[[nodiscard]] nn::Constant read_onnx_tensor(const std::string& path, const OnnxLimits& limits = {});

/// The bytes of an ONNX model of this network, of which parse_onnx() makes the same description; the same
/// network gives the same bytes. Attributes that are fractions are rounded to single precision, as the format
/// holds them. Numbers are written as the kinds that a description knows: floats, doubles, integers of 64
/// bits, truth values; and outputs as floats. HardMish becomes several operators. Models of other kinds,
/// or of other operators outside the standard, are for our reader only.
///
/// \param output_shapes  by name, of outputs whose extents are known; some readers want them
[[nodiscard]] std::string onnx_bytes(const nn::NetworkDescription& network,
                                     const std::map<std::string, nn::Shape>& output_shapes = {});

/// Writes the network as an ONNX model, or leaves the old file as it was; see onnx_bytes().
/// \throws FileError (write)
void write_onnx(const std::string& path, const nn::NetworkDescription& network,
                const std::map<std::string, nn::Shape>& output_shapes = {});

/// New elements of initialisers, by their names.
using WeightValues = std::map<std::string, std::vector<float>>;

/// The weights of a network as it has them now.
[[nodiscard]] WeightValues weight_values(const nn::Network<float>& network);

/// The bytes of an ONNX model with other elements in some of its initialisers, everything else as it was,
/// byte for byte: names, versions, outputs, and texts for people.
///
/// \param bytes  of a model that parse_onnx() reads
/// \param path   of its file, for messages
/// \throws FileError  mismatch if an initialiser has its elements in another file, for weights that are no
///                    initialiser, or one of another number of elements, of another type than FLOAT or with
///                    elements in pieces; malformed as parse_onnx()
[[nodiscard]] std::string with_weights(std::string_view bytes, const std::string& path,
                                       const WeightValues& weights);

}  // namespace tapestry::io

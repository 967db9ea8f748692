#pragma once
#include <tapestry/io/detail/onnx/protobuf_message.hpp>
#include <tapestry/nn/network/network.hpp>

namespace tapestry::io {
/// Supported versions of ONNX's operators; 7 is ONNX 1.2's.
inline constexpr std::int64_t first_opset = 7;
/// The last supported version.
inline constexpr std::int64_t last_opset = 24;

namespace detail {
[[nodiscard]] std::string_view text_of(const std::vector<std::byte>& bytes);
}  // namespace detail

/// Reads an ONNX model that is held in memory.
///
/// Nodes of ONNX's own domain, opset 7 to 24, keep the operator's name. The name of other operators begins
/// with their domain, "com.microsoft.Gelu", so that Network refuses them by name. Initialisers and nodes
/// Constant become constants, even if a graph lists them as inputs. Tensors may be in files beside the model.
/// Nodes that hold graphs, such as If, keep them as attributes; captured values are added to their inputs.
/// Keeps metadata, and the extents that the file states for outputs and inner values. A network does not use
/// them: it computes extents for its own size of input. Other fields for training or for people are left out.
/// Source: onnx.proto and docs/IR.md of ONNX.
///
/// \param path of the file, for messages and to find the files beside it
/// \throws FileError  with the byte and the node or tensor: malformed for files that are not ONNX, are cut or
///                  break its rules, and for unsupported content: other opsets, sparse tensors, types
///                  such as texts and sequences; mismatch for parts that do not fit each other; limit
///                  beyond `limits`
[[nodiscard]] nn::NetworkDescription parse_onnx(std::string_view bytes, const std::string& path,
                                                const OnnxLimits& limits = {});

/// Reads an ONNX model from a file; see parse_onnx(). Takes memory of at most 56 times the file and 1 MiB.
/// \throws FileError  also as RegularFile does
[[nodiscard]] nn::NetworkDescription read_onnx(const std::string& path, const OnnxLimits& limits = {});

/// Reads a file with one TensorProto, such as ONNX's test vectors.
/// \throws FileError  as read_tensor() and RegularFile do
[[nodiscard]] nn::Constant read_onnx_tensor(const std::string& path, const OnnxLimits& limits = {});

/// The bytes of an ONNX model of this network; parse_onnx() reads the same description from them, but for
/// stated_shapes. The same network gives the same bytes. Fractions, of tensors and of attributes, are rounded
/// to single precision: beside inputs of float, weights of double would make a model that other readers
/// refuse. Other tensors are of 64-bit integers or Booleans, and casts lead to these three types; outputs are
/// float. HardMish becomes several operators. Models with other types, or with operators outside the
/// standard, can be read by Tapestry only.
///
/// \param output_shapes by name, of outputs with known extents; some readers require them
/// \throws DomainError for integers that hold NaN, for fractions that are finite in double alone, and
///         for graphs within nodes
[[nodiscard]] std::string onnx_bytes(const nn::NetworkDescription& network,
                                     const std::map<std::string, nn::Shape>& output_shapes = {});

/// Writes the network as an ONNX model, or leaves the old file as it was; see onnx_bytes().
/// \throws FileError (write)
void write_onnx(const std::string& path, const nn::NetworkDescription& network,
                const std::map<std::string, nn::Shape>& output_shapes = {});

/// New elements of initialisers and of nodes Constant, by the names of their values.
using WeightValues = std::map<std::string, std::vector<float>>;

/// The current weights of a network, as the file's constants have them.
/// \throws DomainError for initialisers that the network uses in part
[[nodiscard]] WeightValues weight_values(const nn::Network<float>& network);

/// The bytes of an ONNX model with new elements in some of its initialisers and nodes Constant. Everything
/// else is kept byte for byte: names, versions, outputs, and texts for people.
///
/// \param bytes  of a model that parse_onnx() reads
/// \param path   of its file, for messages
/// \throws FileError  mismatch if a tensor has its elements in another file; for weights that are neither an
///                  initialiser nor the tensor of a node Constant; for another number of elements, another
///                  type than FLOAT, or elements in pieces; malformed as parse_onnx()
[[nodiscard]] std::string with_weights(std::string_view bytes, const std::string& path,
                                       const WeightValues& weights);
}  // namespace tapestry::io

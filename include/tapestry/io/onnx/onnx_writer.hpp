#pragma once
#include <map>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/nn/network/description.hpp>

namespace tapestry::io {

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

}  // namespace tapestry::io

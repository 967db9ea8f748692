#pragma once
#include <map>
#include <string>
#include <string_view>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/nn/network/network.hpp>
#include <vector>

namespace tapestry::io {

/// New elements of initialisers, by their names.
using WeightValues = std::map<std::string, std::vector<float>>;

/// The weights of a network as it has them now.
[[nodiscard]] WeightValues weight_values(const nn::Network<float>& network);

/// The bytes of an ONNX model with other elements in some of its initialisers, everything else as it was,
/// byte for byte: names, versions, outputs, and what it says for people.
///
/// \param bytes  of a model that parse_onnx() reads
/// \param path   of its file, for messages
/// \throws FileError  mismatch if an initialiser has its elements in another file, for weights that are no
///                    initialiser, or one of another number of elements, of another type than FLOAT or with
///                    elements in pieces; malformed as parse_onnx()
[[nodiscard]] std::string with_weights(std::string_view bytes, const std::string& path,
                                       const WeightValues& weights);

}  // namespace tapestry::io

#pragma once
#include <cstddef>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/detect/detector_description.hpp>
#include <tapestry/detect/head.hpp>
#include <tapestry/nn/network/tensor.hpp>
#include <vector>

namespace tapestry::detect {

/// An output of a network that is a run of channels of a head's logits.
struct HeadPiece {
  std::size_t output = 0;  ///< of the network, [1, C, H, W]
  std::size_t head = 0;
  std::size_t first_channel = 0;  ///< within the head's logits
  std::size_t size = 0;           ///< values
};

/// The heads that a network's raw outputs make up.
struct ExportedHeads {
  std::vector<Head> heads{};
  std::vector<HeadPiece> pieces{};
};

/// Puts together the heads of a network's raw outputs: those of one grid are one head, one behind the other.
///
/// \param path    of the network, for messages
/// \param shapes  of the outputs, each [1, C, H, W]
/// \param labels  of the nodes that make them, for messages
/// \throws FileError (mismatch) if they are not what detectors of this kind have
[[nodiscard]] ExportedHeads exported_heads(const std::string& path, const DetectorDescription& kind,
                                           const std::vector<nn::Shape>& shapes,
                                           const std::vector<std::string>& labels, std::size_t input_height,
                                           std::size_t input_width);

}  // namespace tapestry::detect

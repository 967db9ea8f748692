#pragma once
#include <tapestry/nn/network/description.hpp>

namespace tapestry::segment {
/// One stage of the outer U: a residual U-block (RSU) of its own.
struct ResidualU {
  std::size_t levels;  ///< L of RSU-L: scales within the block; at least 2
  std::size_t middle;  ///< channels within the block
  std::size_t out;     ///< channels that leave it
};

/// A network of the U²-Net family, with one dilated stage instead of the published two.
struct U2NetShape {
  std::size_t side = 320;           ///< of the square input, pixels; a multiple of every stride
  std::vector<ResidualU> stages{};  ///< fine to coarse; the decoder has the same but the last
  std::size_t dilated_middle = 16;  ///< channels within the last stage's block, which keeps its scale
  std::size_t dilated_out = 64;     ///< channels that leave it
};

/// The network of a shape with random weights, to be trained: an input "picture" [1, 3, S, S], see
/// u2_net_input(), and outputs "d0", the mask, to "dN", those of the decoder's stages, fine to coarse; all
/// [1, 1, S, S] in [0, 1]. u2_net_logits() names the values before the logistic function. io::write_onnx()
/// writes the network to a file.
///
/// \throws DomainError for no stages, one of fewer than 2 levels or without channels, or a side that is not
///         a multiple of every stride
[[nodiscard]] nn::NetworkDescription u2_net_description(const U2NetShape& shape, std::uint64_t seed);

/// Names of the values whose logistic function is a network's output, in the order of the outputs.
/// \throws FileError (mismatch) for an output that is none
[[nodiscard]] std::vector<std::string> u2_net_logits(const nn::NetworkDescription& network);
}  // namespace tapestry::segment

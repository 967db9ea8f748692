#pragma once
#include <tapestry/nn/network/description.hpp>
#include <tapestry/nn/network/simplify/editable_graph.hpp>

namespace tapestry::nn {

/// The same network with fewer nodes, whose results differ in rounding alone: copies are left out, batch
/// normalisations and constants that scale channels go into the weights before them, patterns that stand for
/// one operation become that (Swish, HardSwish, ChannelShuffle, padded convolutions; InterleaveChannels,
/// PixelUnshuffle and FlattenPixels, which suit tensors stored channels last), and convolutions do their
/// activation and the addition behind them (FusedConv). What has become known beforehand is a constant. A
/// single slope of PRelu that a convolution takes over is a weight no more.
///
/// \param facts     of the description's values, at the extents that the network will have
/// \param in_float  weights that are computed are kept in single precision, for a network in float
[[nodiscard]] NetworkDescription simplified(NetworkDescription description, const NetworkFacts& facts,
                                            bool in_float = false);

}  // namespace tapestry::nn

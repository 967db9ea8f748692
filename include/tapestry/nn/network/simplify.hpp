#pragma once
#include <tapestry/nn/network/description.hpp>
#include <tapestry/nn/network/simplify/editable_graph.hpp>
#include <tapestry/nn/network/simplify/fold_scaling.hpp>
#include <tapestry/nn/network/simplify/fuse_convolution.hpp>
#include <tapestry/nn/network/simplify/merge_patterns.hpp>
#include <tapestry/nn/network/simplify/merge_views.hpp>
#include <utility>

namespace tapestry::nn {

/// The same network with fewer nodes, whose results differ in rounding alone: copies are left out, batch
/// normalisations and constants that scale channels go into the weights before them, patterns that stand for
/// one operation become that (Swish, HardSwish, ChannelShuffle, padded convolutions; InterleaveChannels,
/// PixelUnshuffle and FlattenPixels, which suit tensors stored channels last), and convolutions do their
/// activation and the addition behind them (FusedConv). What has become known beforehand is a constant. A
/// single slope of PRelu that a convolution takes over is a weight no more.
///
/// \param facts  of the description's values, at the extents that the network will have
[[nodiscard]] inline NetworkDescription simplified(NetworkDescription description,
                                                   const NetworkFacts& facts) {
  EditableGraph graph(std::move(description), facts);
  remove_copies(graph);
  merge_patterns(graph);
  merge_views(graph);
  fold_scalings(graph);
  fuse_convolutions(graph);
  return std::move(graph).finish();
}

}  // namespace tapestry::nn

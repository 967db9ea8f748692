#pragma once
#include <concepts>
#include <cstddef>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/detect/network_config.hpp>
#include <tapestry/detect/parameter_layout.hpp>
#include <tapestry/nn/network/description.hpp>

namespace tapestry::detect {

/// The constant that holds a block of parameters in network_description().
[[nodiscard]] std::string constant_name(const ParameterBlock& block);

/// The network of a cfg file and its parameters as operators on named values, [N, C, H, W] from the input
/// "picture" on. The result of layer i is "layer_i", its constants are "layer_i.weights", ".biases" and, with
/// batch normalisation, ".scales", ".means" and ".variances". The outputs are the raw logits of the heads in
/// their order, or the last layer's values in a network without heads.
///
/// Layers that only pass something on (dropout, heads, a route of one whole layer) have no node. What is
/// Darknet's own:
///
///   convolutional    ε of batch normalisation is added inside the root, see NetworkConfig
///   swish            x · Sigmoid(x)
///   hard_mish        HardMish, an operator of ours: its derivative at 0 is 1
///   upsample         Resize to the nearest pixel, rounding down, then a product with `scale`
///   shortcut         a source of other extents is cut or filled up with zeros to those of the layer before;
///                    along an axis with f times the pixels every f-th counts
///   softmax          of values / temperature, of each of `groups` equal runs of an image's values
///   reorg            Reshape, Transpose, Reshape, in Darknet's order
///   scale_channels   a product with one factor for each channel, or for each pixel
///
/// \param parameters     in the order of ParameterLayout
/// \param input_height   of the pictures, in pixels; 0 takes the cfg's own. Some operators state extents, so
///                       that the description is for pictures of this size alone
/// \param input_width    likewise
/// \param batch_statistics  batch normalisation takes the statistics of the pass's batch, and of each such
///                       layer the outputs have "layer_i.batch_means" and "layer_i.batch_variances", biased,
///                       behind those of the heads
/// \throws FileError as infer_shapes(); ShapeError unless there are as many parameters as the cfg
/// needs
template <std::floating_point T>
[[nodiscard]] nn::NetworkDescription network_description(const NetworkConfig& config,
                                                         const Array<T, 1>& parameters,
                                                         std::size_t input_height = 0,
                                                         std::size_t input_width = 0,
                                                         bool batch_statistics = false);

}  // namespace tapestry::detect

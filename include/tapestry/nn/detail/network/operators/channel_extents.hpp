#pragma once
#include <tapestry/nn/detail/network/operators.hpp>

namespace tapestry::nn {
/// A tensor whose axis 1 counts channels, as [images, pixels, channels] if it is stored channels last or else
/// [images, channels, pixels].
struct ChannelExtents {
  std::size_t images = 1, channels = 1, pixels = 1;
  bool is_last = false;

  [[nodiscard]] std::size_t at(std::size_t image, std::size_t channel, std::size_t pixel) const {
    return is_last ? (image * pixels + pixel) * channels + channel
                   : (image * channels + channel) * pixels + pixel;
  }
};

/// \throws DomainError for a tensor without an axis of channels
[[nodiscard]] inline ChannelExtents channel_extents(const OperatorContext& context) {
  const Shape& shape = context.input(0).shape;
  if (shape.size() < 2) throw DomainError({"input 0 is ", shape, ", expected [N, C, …]"});
  ChannelExtents extents;
  extents.is_last = context.channels_last();
  extents.images = shape[0];
  extents.channels = extents.is_last ? shape.back() : shape[1];
  if (extents.channels == 0) throw ShapeError("input 0 has no channels");
  extents.pixels = size_of(shape) / std::max<std::size_t>(1, extents.images * extents.channels);
  return extents;
}

/// \throws ShapeError unless an operand has one value a channel
inline void require_channels(const OperatorContext& context, std::size_t input, std::size_t channels) {
  if (context.input(input).shape != Shape{channels})
    throw ShapeError({"input ", input, " is ", context.input(input).shape, ", expected [", channels, "]"});
}
}  // namespace tapestry::nn

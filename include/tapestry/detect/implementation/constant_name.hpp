#pragma once
#include <tapestry/detect/darknet_model.hpp>

namespace tapestry::detect {
std::string constant_name(const ParameterBlock& block) {
  constexpr std::array<const char*, 5> suffixes{".biases", ".scales", ".means", ".variances", ".weights"};
  return "layer_" + std::to_string(block.layer) + suffixes[static_cast<std::size_t>(block.role)];
}

nn::Shape constant_shape(const NetworkConfig& config, const ParameterBlock& block) {
  const LayerConfig& layer = config.layers[block.layer];
  if (block.role != ParameterRole::weight) return {layer.filters};
  return {layer.filters, block.count / (layer.filters * layer.size * layer.size), layer.size, layer.size};
}
}  // namespace tapestry::detect

#pragma once
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <string_view>
#include <tapestry/core/error.hpp>
#include <tapestry/detect/decode_family.hpp>
#include <tapestry/detect/network_config/layer.hpp>
#include <tapestry/nn/activation.hpp>
#include <vector>

namespace tapestry::detect {

std::vector<std::size_t> inputs_of(const NetworkConfig& config, std::size_t index) {
  const LayerConfig& layer = config.layers[index];
  if (layer.kind == LayerKind::route) return layer.sources;
  std::vector<std::size_t> inputs;
  if (index > 0) inputs.push_back(index - 1);
  for (const std::size_t source : layer.sources) inputs.push_back(source);
  return inputs;
}

std::vector<std::size_t> makers_of_values(const NetworkConfig& config) {
  std::vector<std::size_t> makers;
  for (std::size_t i = 0; i < config.layers.size(); ++i) {
    const LayerConfig& layer = config.layers[i];
    const auto inputs = inputs_of(config, i);
    const bool passes_on = layer.kind == LayerKind::dropout || is_head(layer.kind) ||
                           (layer.kind == LayerKind::route && inputs.size() == 1 && layer.groups == 1);
    const std::size_t shown = inputs.empty() ? picture_value : makers[inputs.front()];
    makers.push_back(passes_on ? shown : i);
  }
  return makers;
}

}  // namespace tapestry::detect

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

}  // namespace tapestry::detect

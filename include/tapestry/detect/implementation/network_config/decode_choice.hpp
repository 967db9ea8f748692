#pragma once
#include <cstddef>
#include <string>
#include <tapestry/detect/decode_family.hpp>
#include <tapestry/detect/network_config/decode_choice.hpp>
#include <tapestry/detect/network_config/layer.hpp>
#include <tapestry/detect/network_config/shape.hpp>
#include <vector>

namespace tapestry::detect::detail {

/// Whether what the head at `index` reads has been through σ.
[[nodiscard]] inline bool reads_activations(const NetworkConfig& config, std::size_t index) {
  if (index == 0) return false;
  const LayerConfig& before = config.layers[index - 1];
  return before.kind == LayerKind::convolutional && before.activation == nn::Activation::logistic;
}

void check_decode(const NetworkConfig& config) {
  const LayerConfig* first = nullptr;
  for (std::size_t i = 0; i < config.layers.size(); ++i) {
    const LayerConfig& layer = config.layers[i];
    if (!is_head(layer.kind)) continue;
    if (first == nullptr) first = &layer;
    if (layer.decode != first->decode)
      throw misfit(config, i, "another decode family than the head before",
                   std::string(name_of(first->decode)) + " as on line " + std::to_string(first->line),
                   std::string(name_of(layer.decode)));
    if (!has_anchors(layer.decode))
      throw misfit(config, i, "a decode family without anchors", std::string(anchored_family_names),
                   std::string(name_of(layer.decode)));
    if (layer.decode == DecodeFamily::scaled && !reads_activations(config, i))
      throw misfit(config, i, "decode family scaled (new_coords=1) needs activations, not logits",
                   "activation=logistic in a [convolutional] layer right before it", "none");
  }
}

}  // namespace tapestry::detect::detail

namespace tapestry::detect {

DecodeFamily decode_family_of(const NetworkConfig& config) {
  for (const LayerConfig& layer : config.layers)
    if (is_head(layer.kind)) return layer.decode;
  return DecodeFamily::darknet;
}

NetworkConfig with_decode(NetworkConfig config, DecodeFamily family) {
  for (std::size_t i = 0; i < config.layers.size(); ++i) {
    LayerConfig& layer = config.layers[i];
    if (!is_head(layer.kind)) continue;
    if (layer.kind == LayerKind::region && family != DecodeFamily::darknet)
      throw detail::misfit(config, i, "a [region] contradicts the decode family asked for", "darknet",
                           std::string(name_of(family)));
    if (layer.decode == DecodeFamily::scaled && family != DecodeFamily::scaled)
      throw detail::misfit(config, i, "new_coords=1 contradicts the decode family asked for", "scaled",
                           std::string(name_of(family)));
    layer.decode = family;
  }
  detail::check_decode(config);
  return config;
}

std::vector<std::string> decode_warnings(const NetworkConfig& config) {
  std::vector<std::string> warnings;
  for (std::size_t i = 0; i < config.layers.size(); ++i) {
    const LayerConfig& layer = config.layers[i];
    if (!is_head(layer.kind) || layer.decode == DecodeFamily::scaled) continue;
    if (detail::reads_activations(config, i))
      warnings.push_back(
          config.name + ":" + std::to_string(layer.line) + ": decode family " +
          std::string(name_of(layer.decode)) +
          " takes the logistic function of outputs of activation=logistic; is it scaled (new_coords=1)?");
  }
  return warnings;
}

}  // namespace tapestry::detect

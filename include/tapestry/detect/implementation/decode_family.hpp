#pragma once
#include <tapestry/detect/implementation/network_config.hpp>

namespace tapestry::detect {
namespace detail {
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
}  // namespace detail

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
      throw detail::misfit(config, i, "a [region] contradicts the requested decode family", "darknet",
                           std::string(name_of(family)));
    if (layer.decode == DecodeFamily::scaled && family != DecodeFamily::scaled)
      throw detail::misfit(config, i, "new_coords=1 contradicts the requested decode family", "scaled",
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

ParameterLayout parameter_layout(const NetworkConfig& config, const std::vector<FeatureShape>& shapes) {
  ParameterLayout layout;
  layout.layers.resize(config.layers.size());
  for (std::size_t i = 0; i < config.layers.size(); ++i) {
    const LayerConfig& layer = config.layers[i];
    if (layer.kind != LayerKind::convolutional) continue;
    const auto append = [&](ParameterRole role, std::size_t count) {
      layout.blocks.push_back({i, role, layout.count, count});
      layout.count += count;
      if (layout.count > detail::largest_element_count)
        throw cfg_error(config.name, layer.line, "too many parameters",
                        "at most " + std::to_string(detail::largest_element_count), "", ErrorKind::limit);
      return layout.blocks.back().offset;
    };
    ConvolutionParameters& own = layout.layers[i];
    own.bias = append(ParameterRole::bias, layer.filters);
    if (layer.batch_normalize) {
      own.scale = append(ParameterRole::scale, layer.filters);
      own.mean = append(ParameterRole::mean, layer.filters);
      own.variance = append(ParameterRole::variance, layer.filters);
    }
    const std::size_t channels = i > 0 ? shapes[i - 1].channels : config.channels;
    own.weight =
        append(ParameterRole::weight, layer.filters * (channels / layer.groups) * layer.size * layer.size);
  }
  return layout;
}

NetworkConfig without_batch_norm(NetworkConfig config) {
  for (LayerConfig& layer : config.layers) layer.batch_normalize = false;
  return config;
}
}  // namespace tapestry::detect

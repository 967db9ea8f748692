#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <tapestry/detect/network_config.hpp>
#include <tapestry/detect/parameter_layout.hpp>
#include <vector>

namespace tapestry::detect {

ParameterLayout parameter_layout(const NetworkConfig& config, const std::vector<FeatureShape>& shapes) {
  ParameterLayout layout;
  layout.layers.resize(config.layers.size());
  for (std::size_t i = 0; i < config.layers.size(); ++i) {
    const LayerConfig& layer = config.layers[i];
    if (layer.kind != LayerKind::convolutional) continue;
    const auto append = [&](ParameterRole role, std::size_t count) {
      layout.blocks.push_back({i, role, layout.count, count});
      layout.count += count;
      if (layout.count > detail::largest_element_count) {
        throw cfg_error(config.name, layer.line, "too many parameters", "at most 2147483648", "",
                        ErrorKind::limit);
      }
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

}  // namespace tapestry::detect

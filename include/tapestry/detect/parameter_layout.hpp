#pragma once
#include <cstddef>
#include <string>
#include <string_view>
#include <tapestry/detect/network_config.hpp>
#include <vector>

namespace tapestry::detect {

/// What a parameter is for, in the order in which Darknet stores them.
enum class ParameterRole { bias, scale, mean, variance, weight };

[[nodiscard]] constexpr std::string_view name_of(ParameterRole role) {
  constexpr std::string_view names[] = {"biases", "scales", "running means", "running variances", "weights"};
  return names[static_cast<std::size_t>(role)];
}

/// Whether parameters are running statistics: state that training passes leave behind, which no step moves.
[[nodiscard]] constexpr bool is_running_statistic(ParameterRole role) {
  return role == ParameterRole::mean || role == ParameterRole::variance;
}

/// A run of parameters of one layer within the flat list of all.
struct ParameterBlock {
  std::size_t layer;  ///< index in NetworkConfig::layers
  ParameterRole role;
  std::size_t offset;
  std::size_t count;
};

/// Position in the flat list where each of a layer's parameters begins.
struct ConvolutionParameters {
  std::size_t bias = 0;      ///< [filters]; with batch normalisation the shift β
  std::size_t scale = 0;     ///< [filters], γ; this and the next two only with batch normalisation
  std::size_t mean = 0;      ///< [filters], running
  std::size_t variance = 0;  ///< [filters], running
  std::size_t weight = 0;    ///< [filters, channels / groups, row, column]
};

/// The flat list of all parameters: layer by layer as in a Darknet weight file, without its header.
struct ParameterLayout {
  std::vector<ParameterBlock> blocks{};
  std::vector<ConvolutionParameters> layers{};  ///< one for each layer; all zero if it has no parameters
  std::size_t count = 0;
};

/// \param shapes  from infer_shapes(); the layout does not depend on the input's size
/// \throws FileError (limit) above 2³¹ parameters
[[nodiscard]] inline ParameterLayout parameter_layout(const NetworkConfig& config,
                                                      const std::vector<FeatureShape>& shapes) {
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

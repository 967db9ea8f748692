#pragma once
#include <tapestry/detect/network_config.hpp>

namespace tapestry::detect {
/// Roles of parameters, in Darknet's order of storage.
enum class ParameterRole { bias, scale, mean, variance, weight };

[[nodiscard]] constexpr std::string_view name_of(ParameterRole role) {
  constexpr std::string_view names[] = {"biases", "scales", "running means", "running variances", "weights"};
  return names[static_cast<std::size_t>(role)];
}

/// Whether parameters are running statistics: training passes change them, optimiser steps do not.
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
[[nodiscard]] ParameterLayout parameter_layout(const NetworkConfig& config,
                                               const std::vector<FeatureShape>& shapes);

/// The same network with convolutions that have a bias only, as after fold_batch_norm().
[[nodiscard]] NetworkConfig without_batch_norm(NetworkConfig config);

/// The parameters of without_batch_norm(config) with the same outputs: with f = γ/√(σ² + ε) of each filter,
/// weights f·w and biases β − f·μ. They are computed in double and rounded once, as a Detector does for
/// inference itself. Training with the batch's own statistics is then impossible.
///
/// \param layout      of config
/// \param parameters  in the order of layout; the result is in the order of the folded network
/// \throws NumericError naming the layer of the first result that is not finite as a float
template <std::floating_point T>
[[nodiscard]] Array<T, 1> fold_batch_norm(const NetworkConfig& config, const ParameterLayout& layout,
                                          const Array<T, 1>& parameters);
}  // namespace tapestry::detect

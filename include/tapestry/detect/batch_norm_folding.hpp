#pragma once
#include <concepts>
#include <cstddef>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/core/finite.hpp>
#include <tapestry/detect/network/prepared_weights.hpp>
#include <tapestry/detect/network_config.hpp>
#include <tapestry/detect/parameter_layout.hpp>
#include <utility>
#include <vector>

namespace tapestry::detect {

/// The same network with convolutions that have a bias only, as after fold_batch_norm().
[[nodiscard]] inline NetworkConfig without_batch_norm(NetworkConfig config) {
  for (LayerConfig& layer : config.layers) layer.batch_normalize = false;
  return config;
}

/// The parameters of without_batch_norm(config) that give the same outputs: with f = γ/√(σ² + ε) of each
/// filter, weights f·w and biases β − f·μ. They are worked out in double and rounded once, as Network does
/// for inference itself; what is lost is training with the batch's own statistics.
///
/// \param layout      of config
/// \param parameters  in the order of layout; the result is in that of the folded network's
/// \throws NumericError naming the layer of the first result that is not finite as a float
template <std::floating_point T>
[[nodiscard]] Array<T, 1> fold_batch_norm(const NetworkConfig& config, const ParameterLayout& layout,
                                          const Array<T, 1>& parameters) {
  std::vector<T> folded;
  folded.reserve(parameters.size());
  const auto append = [&](std::size_t layer, double value) {
    if (!is_finite(static_cast<float>(value)))
      throw NumericError("fold_batch_norm: layer " + std::to_string(layer) + " becomes " +
                         std::to_string(value) + ", expected finite numbers");
    folded.push_back(static_cast<T>(value));
  };
  std::vector<double> factors;
  for (const ParameterBlock& block : layout.blocks) {
    if (block.role != ParameterRole::bias && block.role != ParameterRole::weight) continue;
    const LayerConfig& layer = config.layers[block.layer];
    const ConvolutionParameters& own = layout.layers[block.layer];
    factors.assign(layer.filters, 1);
    for (std::size_t m = 0; layer.batch_normalize && m < layer.filters; ++m)
      factors[m] = detail::folded_factor(parameters, own, m, config.batch_norm_epsilon);
    const std::size_t filter_size = block.count / layer.filters;
    for (std::size_t i = 0; i < block.count; ++i) {
      const std::size_t m = i / filter_size;
      const auto value = static_cast<double>(parameters[block.offset + i]);
      const bool shifts = block.role == ParameterRole::bias && layer.batch_normalize;
      if (block.role == ParameterRole::weight)
        append(block.layer, value * factors[m]);
      else
        append(block.layer,
               shifts ? value - static_cast<double>(parameters[own.mean + m]) * factors[m] : value);
    }
  }
  return array_of(folded);
}

}  // namespace tapestry::detect

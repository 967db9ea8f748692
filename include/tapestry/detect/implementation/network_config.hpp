#pragma once
#include <tapestry/detect/network_config.hpp>
#include <tapestry/detect/parameter_layout.hpp>

namespace tapestry::detect {
namespace detail {
/// Whether the input of the head at `index` has been through σ.
[[nodiscard]] inline bool reads_activations(const NetworkConfig& config, std::size_t index) {
  if (index == 0) return false;
  const LayerConfig& before = config.layers[index - 1];
  return before.kind == LayerKind::convolutional && before.activation == nn::Activation::logistic;
}

/// Factor that batch normalisation with running statistics puts on a filter: scale / √(variance + ε).
template <std::floating_point T>
[[nodiscard]] double folded_factor(const Array<T, 1>& parameters, const ConvolutionParameters& own,
                                   std::size_t filter, double epsilon) {
  return static_cast<double>(parameters[own.scale + filter]) /
         std::sqrt(static_cast<double>(parameters[own.variance + filter]) + epsilon);
}
}  // namespace detail

template <std::floating_point T>
Array<T, 1> fold_batch_norm(const NetworkConfig& config, const ParameterLayout& layout,
                            const Array<T, 1>& parameters) {
  std::vector<T> folded;
  folded.reserve(parameters.size());
  const auto append = [&](std::size_t layer, double value) {
    if (!is_finite(static_cast<float>(value)))
      throw NumericError({"fold_batch_norm: layer ", layer, " becomes ", value, ", expected finite numbers"});
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

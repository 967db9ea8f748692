#pragma once
#include <concepts>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/detect/network_config.hpp>
#include <tapestry/detect/parameter_layout.hpp>

namespace tapestry::detect {

/// The same network with convolutions that have a bias only, as after fold_batch_norm().
[[nodiscard]] NetworkConfig without_batch_norm(NetworkConfig config);

/// The parameters of without_batch_norm(config) that give the same outputs: with f = γ/√(σ² + ε) of each
/// filter, weights f·w and biases β − f·μ. They are worked out in double and rounded once, as a Detector
/// does for inference itself; what is lost is training with the batch's own statistics.
///
/// \param layout      of config
/// \param parameters  in the order of layout; the result is in that of the folded network's
/// \throws NumericError naming the layer of the first result that is not finite as a float
template <std::floating_point T>
[[nodiscard]] Array<T, 1> fold_batch_norm(const NetworkConfig& config, const ParameterLayout& layout,
                                          const Array<T, 1>& parameters);

}  // namespace tapestry::detect

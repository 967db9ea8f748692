#pragma once
#include <concepts>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/detect/batch_norm_folding.hpp>
#include <tapestry/detect/batch_norm_folding_variable.hpp>
#include <tapestry/detect/network_config.hpp>
#include <tapestry/detect/parameter_layout.hpp>

namespace tapestry::detect {

template <std::floating_point T>
ArrayVariable<T, 1> fold_batch_norm(const NetworkConfig& config, const ParameterLayout& layout,
                                    const ArrayVariable<T, 1>& parameters) {
  const auto pullback = [&config, &layout, values = parameters.shared_value()](
                            const Array<T, 1>& folded_adjoint, Array<T, 1>* parameters_adjoint) {
    if (parameters_adjoint != nullptr)
      fold_batch_norm_adjoint(config, layout, *values, folded_adjoint, *parameters_adjoint);
  };
  return record_array<T, 1>(fold_batch_norm(config, layout, parameters.value()), pullback, parameters);
}

template ArrayVariable<float, 1> fold_batch_norm<float>(const NetworkConfig& config,
                                                        const ParameterLayout& layout,
                                                        const ArrayVariable<float, 1>& parameters);
template ArrayVariable<double, 1> fold_batch_norm<double>(const NetworkConfig& config,
                                                          const ParameterLayout& layout,
                                                          const ArrayVariable<double, 1>& parameters);

}  // namespace tapestry::detect

#pragma once
#include <concepts>
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/detect/batch_norm_folding.hpp>
#include <tapestry/detect/network_config.hpp>
#include <tapestry/detect/parameter_layout.hpp>

namespace tapestry::detect {

/// fold_batch_norm() on the tape. A network that is fine-tuned through it keeps its running statistics: a
/// pass of the folded network is that of inference, so that no picture's result depends on the others of its
/// batch, and shifts and scales learn as weights do.
///
/// \param config  and \param layout must outlive the tape's last reverse()
/// \throws NumericError, ShapeError as fold_batch_norm(); DomainError if parameters are on no active tape
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 1> fold_batch_norm(const NetworkConfig& config, const ParameterLayout& layout,
                                                  const ArrayVariable<T, 1>& parameters);

}  // namespace tapestry::detect

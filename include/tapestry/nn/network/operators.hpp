#pragma once
#include <concepts>
#include <tapestry/nn/network/operator_table.hpp>

namespace tapestry::nn {

/// Every operator that networks may be made of.
template <std::floating_point T>
[[nodiscard]] const OperatorTable<T>& operators();

#if defined(TAPESTRY_EXTERN_KERNELS)  // compiled where the program includes implementation.hpp
extern template const OperatorTable<float>& operators<float>();
extern template const OperatorTable<double>& operators<double>();
#endif

}  // namespace tapestry::nn

#if !defined(TAPESTRY_EXTERN_KERNELS)
#include <tapestry/nn/network/operator_definitions.hpp>
#endif

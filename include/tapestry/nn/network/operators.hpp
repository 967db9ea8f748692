#pragma once
#include <concepts>
#include <tapestry/nn/network/operator_table.hpp>

namespace tapestry::nn {

/// Every operator that networks may be made of.
template <std::floating_point T>
[[nodiscard]] const OperatorTable<T>& operators();

}  // namespace tapestry::nn

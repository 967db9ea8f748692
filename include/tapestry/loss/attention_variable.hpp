#pragma once
#include <concepts>
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/autodiff/variable.hpp>
#include <tapestry/loss/attention.hpp>

namespace tapestry::loss {

/// attention() of a heat map on the active tape; its pullback is attention_adjoint().
///
/// \param heat  [H, W]
template <std::floating_point T>
[[nodiscard]] Variable<T> attention(const ArrayVariable<T, 2>& heat);

}  // namespace tapestry::loss

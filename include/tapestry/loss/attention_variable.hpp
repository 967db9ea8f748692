#pragma once
#include <concepts>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/loss/attention.hpp>

namespace tapestry::loss {

/// attention() of a heat map on the active tape; its pullback is attention_adjoint().
///
/// \param heat  [H, W]
template <std::floating_point T>
[[nodiscard]] Variable<T> attention(const ArrayVariable<T, 2>& heat) {
  const auto pullback = [kept = heat.value()](T loss_adjoint, Array<T, 2>* heat_adjoint) {
    attention_adjoint(kept, loss_adjoint, *heat_adjoint);
  };
  return record_scalar(attention(heat.value()), pullback, heat);
}

}  // namespace tapestry::loss

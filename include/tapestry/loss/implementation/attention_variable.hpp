#pragma once
#include <concepts>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/loss/attention.hpp>
#include <tapestry/loss/attention_variable.hpp>

namespace tapestry::loss {

template <std::floating_point T>
Variable<T> attention(const ArrayVariable<T, 2>& heat) {
  const auto pullback = [kept = heat.value()](T loss_adjoint, Array<T, 2>* heat_adjoint) {
    attention_adjoint(kept, loss_adjoint, *heat_adjoint);
  };
  return record_scalar(attention(heat.value()), pullback, heat);
}

template Variable<float> attention<float>(const ArrayVariable<float, 2>& heat);
template Variable<double> attention<double>(const ArrayVariable<double, 2>& heat);

}  // namespace tapestry::loss

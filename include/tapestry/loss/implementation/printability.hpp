#pragma once
#include <tapestry/autodiff/record.hpp>
#include <tapestry/loss/printability.hpp>

namespace tapestry::loss {
template <std::floating_point T>
Variable<T> non_printability(const ArrayVariable<T, 2>& texels, std::shared_ptr<const Array<T, 2>> used,
                             std::shared_ptr<const Array<double, 2>> palette, double spread) {
  const T value = non_printability(texels.value(), *used, *palette, spread);
  const auto pullback = [at = texels.shared_value(), of_texels = std::move(used),
                         printable = std::move(palette), spread](T adjoint, Array<T, 2>* texels_adjoint) {
    non_printability_adjoint(*at, *of_texels, *printable, spread, adjoint, *texels_adjoint);
  };
  return record_scalar(value, pullback, texels);
}
}  // namespace tapestry::loss

#pragma once
#include <concepts>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/detect/input_encoding.hpp>
#include <tapestry/detect/input_encoding_variable.hpp>

namespace tapestry::detect {

template <std::floating_point T>
ArrayVariable<T, 4> encoded(const ArrayVariable<T, 4>& pictures, const InputEncoding& encoding) {
  const auto pullback = [encoding](const Array<T, 4>& input_adjoint, Array<T, 4>* pictures_adjoint) {
    encoded_adjoint(input_adjoint, encoding, *pictures_adjoint);
  };
  return record_array(encoded(pictures.value(), encoding), pullback, pictures);
}

template ArrayVariable<float, 4> encoded<float>(const ArrayVariable<float, 4>& pictures,
                                                const InputEncoding& encoding);
template ArrayVariable<double, 4> encoded<double>(const ArrayVariable<double, 4>& pictures,
                                                  const InputEncoding& encoding);

}  // namespace tapestry::detect

#pragma once
#include <concepts>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/detect/input_encoding.hpp>

namespace tapestry::detect {

/// encoded() of pictures on the tape; its pullback is encoded_adjoint(). Errors as there.
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 4> encoded(const ArrayVariable<T, 4>& pictures,
                                          const InputEncoding& encoding) {
  const auto pullback = [encoding](const Array<T, 4>& input_adjoint, Array<T, 4>* pictures_adjoint) {
    encoded_adjoint(input_adjoint, encoding, *pictures_adjoint);
  };
  return record_array(encoded(pictures.value(), encoding), pullback, pictures);
}

}  // namespace tapestry::detect

#pragma once
#include <concepts>
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/detect/input_encoding.hpp>

namespace tapestry::detect {

/// encoded() of pictures on the tape; its pullback is encoded_adjoint(). Errors as there.
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 4> encoded(const ArrayVariable<T, 4>& pictures, const InputEncoding& encoding);

}  // namespace tapestry::detect

#pragma once
#include <cstddef>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/image/resize.hpp>

namespace tapestry::image {

/// resize_bilinear() of a picture on the tape; its pullback is resize_bilinear_adjoint().
template <class T>
[[nodiscard]] ArrayVariable<T, 3> resize_bilinear(const ArrayVariable<T, 3>& picture, std::size_t height,
                                                  std::size_t width) {
  const auto pullback = [](const Array<T, 3>& resized_adjoint, Array<T, 3>* picture_adjoint) {
    resize_bilinear_adjoint(resized_adjoint, *picture_adjoint);
  };
  return record_array(resize_bilinear(picture.value(), height, width), pullback, picture);
}

}  // namespace tapestry::image

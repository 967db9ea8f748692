#pragma once
#include <cstddef>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/image/letterbox.hpp>

namespace tapestry::image {

/// letterboxed() of a picture on the tape; errors as there.
/// \param margin  the value beside the picture, a colour in [0, 1]
template <class T>
[[nodiscard]] ArrayVariable<T, 3> letterboxed(const ArrayVariable<T, 3>& picture, std::size_t height,
                                              std::size_t width, T margin) {
  const auto pullback = [](const Array<T, 3>& canvas_adjoint, Array<T, 3>* picture_adjoint) {
    letterboxed_adjoint(canvas_adjoint, *picture_adjoint);
  };
  return record_array(letterboxed(picture.value(), height, width, margin), pullback, picture);
}

}  // namespace tapestry::image

#pragma once
#include <cstddef>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/image/letterbox.hpp>

namespace tapestry::image {

/// fitted() of a picture on the tape; its pullback is fitted_adjoint(). Errors as there.
template <class T>
[[nodiscard]] ArrayVariable<T, 3> fitted(const ArrayVariable<T, 3>& picture, std::size_t height,
                                         std::size_t width, const Fit& fit) {
  const auto pullback = [kind = fit.kind](const Array<T, 3>& canvas_adjoint, Array<T, 3>* picture_adjoint) {
    fitted_adjoint(canvas_adjoint, kind, *picture_adjoint);
  };
  return record_array(fitted(picture.value(), height, width, fit), pullback, picture);
}

/// letterboxed() of a picture on the tape; errors as there.
/// \param margin  the value beside the picture, a colour in [0, 1]
template <class T>
[[nodiscard]] ArrayVariable<T, 3> letterboxed(const ArrayVariable<T, 3>& picture, std::size_t height,
                                              std::size_t width, T margin) {
  return fitted(picture, height, width, {FitKind::letterbox, static_cast<double>(margin)});
}

}  // namespace tapestry::image

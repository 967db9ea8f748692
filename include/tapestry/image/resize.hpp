#pragma once
#include <tapestry/autodiff/record.hpp>
#include <tapestry/core/compiled.hpp>

namespace tapestry::image {
namespace detail {
void require_size(const char* operation, std::size_t rows, std::size_t columns);
}  // namespace detail

/// Bilinear resampling with half-pixel centres and clamped edges, without a low-pass filter: what
/// OpenCV calls INTER_LINEAR.
///
///   out[i, j] = in at row (i + ½)·H/height − ½, column (j + ½)·W/width − ½
///
/// \param picture  [H, W, C]
/// \returns        [height, width, C]
/// \throws DomainError if a side is 0 or beyond 65536
template <std::floating_point T>
[[nodiscard]] Array<T, 3> resize_bilinear(const Array<T, 3>& picture, std::size_t height, std::size_t width);

/// Adds the transpose of resize_bilinear() times resized_adjoint to picture_adjoint. Each input row
/// gathers from its output rows in ascending order, so the sums do not depend on the threads.
///
/// \param resized_adjoint  [height, width, C]
/// \param picture_adjoint  [H, W, C]
/// \throws ShapeError if the channels differ
/// \throws DomainError if a side is 0 or beyond 65536
template <std::floating_point T>
void resize_bilinear_adjoint(const Array<T, 3>& resized_adjoint, Array<T, 3>& picture_adjoint);

/// resize_bilinear() of a picture on the tape; its pullback is resize_bilinear_adjoint().
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 3> resize_bilinear(const ArrayVariable<T, 3>& picture, std::size_t height,
                                                  std::size_t width) {
  const auto pullback = [](const Array<T, 3>& resized_adjoint, Array<T, 3>* picture_adjoint) {
    resize_bilinear_adjoint(resized_adjoint, *picture_adjoint);
  };
  return record_array(resize_bilinear(picture.value(), height, width), pullback, picture);
}

/// The same on a tape of duals.
template <DualNumber D>
[[nodiscard]] ArrayVariable<D, 3> resize_bilinear(const ArrayVariable<D, 3>& picture, std::size_t height,
                                                  std::size_t width) {
  return record_linear([=](const auto& x) { return resize_bilinear(x, height, width); }, picture);
}
}  // namespace tapestry::image

#pragma once
#include <concepts>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>

namespace tapestry::image {

/// A Gaussian blur, as of a lens out of focus; of unequal deviations roughly that of a moving camera.
struct Blur {
  double across_px = 0;  ///< standard deviation along rows, at most 64
  double down_px = 0;    ///< and along columns
};

/// The blurred picture; beyond its edges it goes on as at the edge, so that a constant stays one.
///
/// \param picture  [H, W, C], not empty
/// \returns        [H, W, C]
/// \throws DomainError for a deviation that is negative or above 64 pixels
template <std::floating_point T>
[[nodiscard]] Array<T, 3> transformed(const Array<T, 3>& picture, const Blur& blur);

/// Adds the transpose of transformed() times `out_adjoint` to `picture_adjoint`; all are [H, W, C].
/// \throws ShapeError if extents differ, or as transformed()
template <std::floating_point T>
void transformed_adjoint(const Array<T, 3>& picture, const Blur& blur, const Array<T, 3>& out_adjoint,
                         Array<T, 3>& picture_adjoint);

}  // namespace tapestry::image

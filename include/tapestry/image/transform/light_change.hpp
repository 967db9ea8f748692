#pragma once
#include <array>
#include <concepts>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>

namespace tapestry::image {

/// Another exposure, another colour of the light, and the soft edge of a shadow across the picture.
///
/// Light is multiplied, not its code in the picture: a gain g of light is one of g^(1/2.2) of encoded values.
/// The power 2.2 stands for the sRGB curve, from which a stop of exposure, up or down, then differs by at
/// most 0.018.
struct LightChange {
  std::array<double, 3> gain{1, 1, 1};  ///< of red, green and blue light, above 0
  double shadow = 0;                    ///< share of light that the shadow takes, 0 to below 1
  double shadow_rad = 0;                ///< direction into the shadow: 0 to the right, π/2 down
  double shadow_at = 0;                 ///< the edge's place from the middle, in half widths
  double shadow_softness = 0.1;         ///< half width of the edge, in half widths of the picture, above 0
};

/// The picture in the changed light; what becomes brighter than white is white.
///
/// \param picture  [H, W, 3]
/// \returns        [H, W, 3]
/// \throws ShapeError if there are not three channels; DomainError for a change beyond its ranges
template <std::floating_point T>
[[nodiscard]] Array<T, 3> transformed(const Array<T, 3>& picture, const LightChange& change);

/// Adds the derivatives of transformed() to `picture_adjoint`; those of white pixels are 0. All are [H, W,
/// 3]. \throws ShapeError if extents differ, or as transformed()
template <std::floating_point T>
void transformed_adjoint(const Array<T, 3>& picture, const LightChange& change,
                         const Array<T, 3>& out_adjoint, Array<T, 3>& picture_adjoint);

}  // namespace tapestry::image

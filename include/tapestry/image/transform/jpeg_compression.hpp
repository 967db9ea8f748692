#pragma once
#include <concepts>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/image/transform/colour_change.hpp>

namespace tapestry::image {

/// What JPEG does to a picture: ITU-T T.81 with the tables of its Annex K, scaled by quality as the
/// Independent JPEG Group's programs do, colours as JFIF has them.
struct JpegCompression {
  int quality = 75;              ///< 1 to 100
  bool is_chroma_halved = true;  ///< in both directions, 4:2:0, and doubled again without smoothing
  bool is_rounding_smooth = false;  ///< x ↦ ⌊x⌉ + (x − ⌊x⌉)³, which has slopes; else to whole numbers
};

namespace detail {

void require_sound(const JpegCompression& jpeg);

}  // namespace detail

/// The picture after compression and decompression.
///
/// \param picture  [H, W, 3] in [0, 1], not empty
/// \returns        [H, W, 3] in [0, 1]
/// \throws DomainError for a quality that is not 1 to 100; ShapeError if there are not three channels
template <std::floating_point T>
[[nodiscard]] Array<T, 3> transformed(const Array<T, 3>& picture, const JpegCompression& jpeg);

/// Adds the derivatives of transformed() to `picture_adjoint`: those of smooth rounding, exact where it is
/// smooth and in place of the missing ones where it is not. Source of the surrogate: Shin and Song,
/// "JPEG-resistant adversarial images" (2017). All are [H, W, 3].
/// \throws ShapeError if extents differ, or as transformed()
template <std::floating_point T>
void transformed_adjoint(const Array<T, 3>& picture, const JpegCompression& jpeg,
                         const Array<T, 3>& out_adjoint, Array<T, 3>& picture_adjoint);

}  // namespace tapestry::image

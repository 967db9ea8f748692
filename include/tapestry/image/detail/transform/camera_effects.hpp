#pragma once
#include <tapestry/image/transform/colour_change.hpp>

namespace tapestry::image {
/// A Gaussian blur, as of a lens out of focus; with unequal deviations roughly the blur of a moving camera.
struct Blur {
  double across_px = 0;  ///< standard deviation along rows, at most 64
  double down_px = 0;    ///< and along columns
};

/// The blurred picture; it continues beyond its edges with the edge's values, so that a constant stays one.
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

/// Noise of a camera's sensor, of variance shot · value + read². Source of the model: Foi et al., "Practical
/// Poissonian-Gaussian noise modeling and fitting for single-image raw-data" (2008), here for encoded values.
struct SensorNoise {
  double shot = 0;     ///< variance a unit of value
  double read = 0.01;  ///< standard deviation in the dark, above 0
  std::uint64_t seed = 1;
};

/// The picture with noise, not clipped to 0 … 1.
///
/// \param picture  [H, W, C]; below 0 counts as 0 for the variance
/// \returns        [H, W, C]
/// \throws DomainError if shot is below 0 or read is not above it
template <std::floating_point T>
[[nodiscard]] Array<T, 3> transformed(const Array<T, 3>& picture, const SensorNoise& noise);

/// Adds the derivatives of transformed() to `picture_adjoint`; all are [H, W, C].
/// \throws ShapeError if extents differ, or as transformed()
template <std::floating_point T>
void transformed_adjoint(const Array<T, 3>& picture, const SensorNoise& noise, const Array<T, 3>& out_adjoint,
                         Array<T, 3>& picture_adjoint);

/// JPEG compression of a picture: ITU-T T.81 with the tables of its Annex K, scaled by quality as the
/// Independent JPEG Group's programs do, colours as JFIF has them.
struct JpegCompression {
  int quality = 75;              ///< 1 to 100
  bool is_chroma_halved = true;  ///< in both directions, 4:2:0, and doubled again without smoothing
  bool is_rounding_smooth = false;  ///< x ↦ ⌊x⌉ + (x − ⌊x⌉)³, which has slopes; else to whole numbers
};

namespace detail {
void require_sound(const SensorNoise& noise);
void require_sound(const JpegCompression& jpeg);
}  // namespace detail

/// The picture after compression and decompression.
///
/// \param picture  [H, W, 3] in [0, 1], not empty
/// \returns        [H, W, 3] in [0, 1]
/// \throws DomainError for a quality that is not 1 to 100; ShapeError if there are not three channels
template <std::floating_point T>
[[nodiscard]] Array<T, 3> transformed(const Array<T, 3>& picture, const JpegCompression& jpeg);

/// Adds the derivatives of transformed() to `picture_adjoint`: those of smooth rounding. They are exact if
/// rounding is smooth, and stand for the missing ones if it is not. Source of the surrogate: Shin and Song,
/// "JPEG-resistant adversarial images" (2017). All are [H, W, 3].
/// \throws ShapeError if extents differ, or as transformed()
template <std::floating_point T>
void transformed_adjoint(const Array<T, 3>& picture, const JpegCompression& jpeg,
                         const Array<T, 3>& out_adjoint, Array<T, 3>& picture_adjoint);
}  // namespace tapestry::image

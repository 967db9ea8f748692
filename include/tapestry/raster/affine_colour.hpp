#pragma once
#include <array>
#include <concepts>
#include <cstddef>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>

namespace tapestry::raster {

/// Exposure, tint and haze of one view, to match a photograph: colour ← gain · colour + bias.
template <std::floating_point T>
struct AffineColour {
  Array<T, 3> gain;  ///< [H, W, 3]
  Array<T, 3> bias;  ///< [H, W, 3]
};

/// The same gain and bias at every pixel.
template <std::floating_point T>
[[nodiscard]] AffineColour<T> uniform_affine_colour(std::size_t height, std::size_t width,
                                                    const std::array<double, 3>& gain,
                                                    const std::array<double, 3>& bias) {
  AffineColour<T> map{Array<T, 3>(Extents<3>{height, width, 3}), Array<T, 3>(Extents<3>{height, width, 3})};
  for (std::size_t i = 0; i < map.gain.size(); ++i) {
    map.gain.data()[i] = static_cast<T>(gain[i % 3]);
    map.bias.data()[i] = static_cast<T>(bias[i % 3]);
  }
  return map;
}

/// Applies a view's affine colour to its render: gain · P + bias · c, P being colour times coverage c, so
/// that a pixel that shows nothing stays empty. A view without affine colour does not call this.
///
/// \param image     P, [H, W, 3], as render() gives it
/// \param coverage  c, [H, W]
/// \throws ShapeError unless gain, bias and coverage are of the image's size
template <std::floating_point T>
[[nodiscard]] Array<T, 3> affine_colour(Array<T, 3> image, const Array<T, 2>& coverage,
                                        const AffineColour<T>& map) {
  require_shape("affine_colour", "coverage", coverage, {image.shape(0), image.shape(1)});
  require_shape("affine_colour", "gain", map.gain, image.shape());
  require_shape("affine_colour", "bias", map.bias, image.shape());
  for (std::size_t i = 0; i < image.size(); ++i)
    image.data()[i] = map.gain.data()[i] * image.data()[i] + map.bias.data()[i] * coverage.data()[i / 3];
  return image;
}

/// Adds gain · affine_adjoint to image_adjoint, [H, W, 3].
template <std::floating_point T>
void affine_colour_adjoint(const AffineColour<T>& map, const Array<T, 3>& affine_adjoint,
                           Array<T, 3>& image_adjoint) {
  require_shape("affine_colour_adjoint", "gain", map.gain, affine_adjoint.shape());
  require_shape("affine_colour_adjoint", "image_adjoint", image_adjoint, affine_adjoint.shape());
  for (std::size_t i = 0; i < image_adjoint.size(); ++i)
    image_adjoint.data()[i] += map.gain.data()[i] * affine_adjoint.data()[i];
}

/// Adds the derivatives with respect to gain and bias, P · affine_adjoint and c · affine_adjoint, to those of
/// map_adjoint, for a map that is itself fitted; arguments otherwise as in affine_colour().
template <std::floating_point T>
void affine_colour_map_adjoint(const Array<T, 3>& image, const Array<T, 2>& coverage,
                               const Array<T, 3>& affine_adjoint, AffineColour<T>& map_adjoint) {
  require_shape("affine_colour_map_adjoint", "coverage", coverage, {image.shape(0), image.shape(1)});
  require_shape("affine_colour_map_adjoint", "affine_adjoint", affine_adjoint, image.shape());
  require_shape("affine_colour_map_adjoint", "gain", map_adjoint.gain, image.shape());
  require_shape("affine_colour_map_adjoint", "bias", map_adjoint.bias, image.shape());
  for (std::size_t i = 0; i < image.size(); ++i) {
    map_adjoint.gain.data()[i] += image.data()[i] * affine_adjoint.data()[i];
    map_adjoint.bias.data()[i] += coverage.data()[i / 3] * affine_adjoint.data()[i];
  }
}

}  // namespace tapestry::raster

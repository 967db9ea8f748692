#pragma once
#include <concepts>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/image/transform/blur.hpp>
#include <tapestry/image/transform/colour_change.hpp>
#include <tapestry/image/transform/jpeg_compression.hpp>
#include <tapestry/image/transform/light_change.hpp>
#include <tapestry/image/transform/sensor_noise.hpp>
#include <tapestry/image/transform/warp.hpp>
#include <variant>
#include <vector>

namespace tapestry::image {

/// Something that happens to a picture between the scene and the detector, with its settings.
using Transformation = std::variant<Warp, LightChange, ColourChange, Blur, SensorNoise, JpegCompression>;

/// What happens to one picture, in this order; nothing when empty.
using TransformationChain = std::vector<Transformation>;

/// The pictures of a chain: the first one, [H, W, 3], and what each transformation has made of it.
/// \throws as the transformations
template <std::floating_point T>
[[nodiscard]] std::vector<Array<T, 3>> transformation_stages(Array<T, 3> picture,
                                                             const TransformationChain& chain);

/// The picture after all of a chain, [H, W, 3]. \throws as the transformations
template <std::floating_point T>
[[nodiscard]] Array<T, 3> transformed(Array<T, 3> picture, const TransformationChain& chain);

/// Adds the derivatives of a chain to `picture_adjoint`.
///
/// \param stages       of transformation_stages()
/// \param out_adjoint  and \param picture_adjoint [H, W, 3]
/// \throws ShapeError if extents differ, or there are not as many stages
template <std::floating_point T>
void transformed_adjoint(const std::vector<Array<T, 3>>& stages, const TransformationChain& chain,
                         const Array<T, 3>& out_adjoint, Array<T, 3>& picture_adjoint);

}  // namespace tapestry::image

#pragma once
#include <concepts>
#include <cstddef>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/image/transform/blur.hpp>
#include <tapestry/image/transform/colour_change.hpp>
#include <tapestry/image/transform/jpeg_compression.hpp>
#include <tapestry/image/transform/light_change.hpp>
#include <tapestry/image/transform/sensor_noise.hpp>
#include <tapestry/image/transform/warp.hpp>
#include <utility>
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
                                                             const TransformationChain& chain) {
  std::vector<Array<T, 3>> stages;
  stages.reserve(chain.size() + 1);
  stages.push_back(std::move(picture));
  for (const Transformation& transformation : chain)
    stages.push_back(
        std::visit([&](const auto& one) { return transformed(stages.back(), one); }, transformation));
  return stages;
}

/// The picture after all of a chain, [H, W, 3]. \throws as the transformations
template <std::floating_point T>
[[nodiscard]] Array<T, 3> transformed(Array<T, 3> picture, const TransformationChain& chain) {
  for (const Transformation& transformation : chain)
    picture = std::visit([&](const auto& one) { return transformed(picture, one); }, transformation);
  return picture;
}

/// Adds the derivatives of a chain to `picture_adjoint`.
///
/// \param stages       of transformation_stages()
/// \param out_adjoint  and \param picture_adjoint [H, W, 3]
/// \throws ShapeError if extents differ, or there are not as many stages
template <std::floating_point T>
void transformed_adjoint(const std::vector<Array<T, 3>>& stages, const TransformationChain& chain,
                         const Array<T, 3>& out_adjoint, Array<T, 3>& picture_adjoint) {
  if (stages.size() != chain.size() + 1) throw ShapeError("transformed_adjoint: stages of another chain");
  require_shape("transformed_adjoint", "out_adjoint", out_adjoint, stages.back().shape());
  require_shape("transformed_adjoint", "picture_adjoint", picture_adjoint, stages.back().shape());
  Array<T, 3> adjoint = out_adjoint;
  for (std::size_t i = chain.size(); i-- > 0;) {
    Array<T, 3> before = xt::zeros_like(adjoint);
    std::visit([&](const auto& one) { transformed_adjoint(stages[i], one, adjoint, before); }, chain[i]);
    adjoint = std::move(before);
  }
  for (std::size_t i = 0; i < adjoint.size(); ++i) picture_adjoint.data()[i] += adjoint.data()[i];
}

}  // namespace tapestry::image

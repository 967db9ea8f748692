#pragma once
#include <concepts>
#include <cstddef>
#include <memory>
#include <string>
#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/camouflage/shape_parameter.hpp>
#include <tapestry/camouflage/view.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/image/over_variable.hpp>
#include <tapestry/raster/render_variable.hpp>
#include <utility>

namespace tapestry::camouflage {

/// A view whose car has another shape, on the tape.
template <std::floating_point T>
struct RedrawnView {
  ArrayVariable<T, 3> render;                   ///< m·O, [H, W, 3], multiplied by its coverage m·c
  ArrayVariable<T, 3> picture;                  ///< I_adv, [H, W, 3], see picture_of()
  std::shared_ptr<const Array<T, 2>> interior;  ///< as View::interior, of the whole picture; held still
};

/// Draws a view anew, differentiable by texels and positions, right through silhouettes. The mask stays that
/// of the frame: where the car grows beyond it, it is cut off, and where it shrinks, the frame shows.
///
/// \param texels     [texel, 3], in the view's colour space
/// \param positions  [V, 3]
/// \throws DomainError if the view does not keep what it is drawn by, see sight_of(); else as
///         raster::render()
template <std::floating_point T>
[[nodiscard]] RedrawnView<T> redrawn(const View<T>& view, const ShapeParameter& shape,
                                     const ArrayVariable<T, 2>& texels,
                                     const ArrayVariable<T, 2>& positions) {
  if (!view.sight) throw DomainError("redrawn: view " + view.name + " does not keep what it is drawn by");
  const auto& [camera, light, mask, samples] = *view.sight;
  const std::size_t height = mask.shape(0), width = mask.shape(1);
  const auto drawn = raster::render(shape.car, camera, height, width, light,
                                    raster::RenderInputs<T>{.texels = texels, .positions = positions},
                                    raster::BoundaryIntegral{samples, true, shape.edges});
  Array<T, 3> mask_of_channels(Extents<3>{height, width, 3});
  for (std::size_t i = 0; i < mask_of_channels.size(); ++i) mask_of_channels.data()[i] = mask.data()[i / 3];
  const ArrayVariable<T, 3> render = drawn.picture * ArrayVariable<T, 3>(std::move(mask_of_channels));
  const ArrayVariable<T, 2> coverage = drawn.coverage * ArrayVariable<T, 2>(mask);
  return {render, image::over(render, coverage, ArrayVariable<T, 3>(view.background), 0, 0, view.space),
          std::make_shared<const Array<T, 2>>(detail::interior_of(coverage.value()))};
}

}  // namespace tapestry::camouflage

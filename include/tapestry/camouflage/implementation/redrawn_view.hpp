#pragma once
#include <concepts>
#include <cstddef>
#include <memory>
#include <string>
#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/camouflage/redrawn_view.hpp>
#include <tapestry/camouflage/shape_parameter.hpp>
#include <tapestry/camouflage/view.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/image/over_variable.hpp>
#include <tapestry/raster/render_variable.hpp>
#include <utility>

namespace tapestry::camouflage {

template <std::floating_point T>
RedrawnView<T> redrawn(const View<T>& view, const ShapeParameter& shape, const ArrayVariable<T, 2>& texels,
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

template decltype(redrawn<float>) redrawn<float>;
template decltype(redrawn<double>) redrawn<double>;

}  // namespace tapestry::camouflage

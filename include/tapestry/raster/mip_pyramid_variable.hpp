#pragma once
#include <concepts>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/raster/mip_pyramid.hpp>

namespace tapestry::raster {

/// mip_pyramid() on the active tape; its pullback is mip_pyramid_adjoint(). Passive texels record nothing.
/// \throws ShapeError as mip_pyramid()
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 2> mip_pyramid(const TextureLayout& layout,
                                              const ArrayVariable<T, 2>& texels) {
  const auto pullback = [layout](const Array<T, 2>& pyramid_adjoint, Array<T, 2>* texels_adjoint) {
    mip_pyramid_adjoint(layout, pyramid_adjoint, *texels_adjoint);
  };
  return record_array(mip_pyramid(layout, texels.value()), pullback, texels);
}

}  // namespace tapestry::raster

#pragma once
#include <concepts>
#include <memory>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/raster/mip_pyramid.hpp>
#include <tapestry/raster/mip_pyramid_variable.hpp>

namespace tapestry::raster {

template <std::floating_point T>
ArrayVariable<T, 2> stored_texels(const std::shared_ptr<const MipPyramid>& pyramid,
                                  const ArrayVariable<T, 2>& texels) {
  if (!pyramid) return texels;
  const auto pullback = [pyramid](const Array<T, 2>& pyramid_adjoint, Array<T, 2>* texels_adjoint) {
    pyramid->adjoint(pyramid_adjoint, *texels_adjoint);
  };
  return record_array((*pyramid)(texels.value()), pullback, texels);
}

template ArrayVariable<float, 2> stored_texels<float>(const std::shared_ptr<const MipPyramid>& pyramid,
                                                      const ArrayVariable<float, 2>& texels);
template ArrayVariable<double, 2> stored_texels<double>(const std::shared_ptr<const MipPyramid>& pyramid,
                                                        const ArrayVariable<double, 2>& texels);

}  // namespace tapestry::raster

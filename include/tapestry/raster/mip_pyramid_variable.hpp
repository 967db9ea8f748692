#pragma once
#include <concepts>
#include <memory>
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/raster/mip_pyramid.hpp>

namespace tapestry::raster {

/// stored_texels() on the active tape, which keeps the pyramid alive; its pullback is MipPyramid::adjoint().
/// Passive texels record nothing.
/// \throws ShapeError as the pyramid does
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 2> stored_texels(const std::shared_ptr<const MipPyramid>& pyramid,
                                                const ArrayVariable<T, 2>& texels);

}  // namespace tapestry::raster

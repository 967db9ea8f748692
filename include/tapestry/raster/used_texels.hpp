#pragma once
#include <array>
#include <concepts>
#include <cstddef>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/raster/bake.hpp>
#include <tapestry/raster/painted_mesh.hpp>

namespace tapestry::raster {

/// Which texels of an atlas a painted face refers to, see for_each_atlas_texel().
///
/// \returns  [height, width] of the atlas, 1 where one does and 0 elsewhere
/// \throws DomainError if the texture is no atlas
template <std::floating_point T>
[[nodiscard]] Array<T, 2> used_texels(const PaintedMesh& car) {
  if (car.layout.kind != TextureKind::atlas)
    throw DomainError("used_texels: expected an atlas, found a texture of another kind");
  auto used = zeros<T, 2>({car.layout.height, car.layout.width});
  for (std::size_t face = 0; face < car.painted.size(); ++face)
    if (car.painted[face] != 0)
      for_each_atlas_texel(
          car.mesh, car.layout, face,
          [&](std::size_t row, std::size_t column, const std::array<double, 3>&) { used(row, column) = 1; });
  return used;
}

}  // namespace tapestry::raster

#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/raster/bake.hpp>
#include <tapestry/raster/fragment_shader.hpp>
#include <tapestry/raster/lighting.hpp>
#include <tapestry/raster/mip_pyramid.hpp>
#include <tapestry/raster/surface.hpp>
#include <tapestry/raster/texture_layout.hpp>
#include <vector>

namespace tapestry::raster::detail {

std::array<double, 3> clamped_barycentric(std::array<double, 3> b) {
  double sum = 0;
  for (double& value : b) sum += value = std::max(value, 0.0);
  for (double& value : b) value = sum > 0 ? value / sum : 1.0 / 3;
  return b;
}

template <std::floating_point T>
void require_bakeable(const char* operation, const PaintedMesh& body, const Array<T, 2>& texels) {
  require_layout(operation, body);
  require_shape(operation, "texels", texels, {body.layout.texel_count(body.mesh), 3});
}

}  // namespace tapestry::raster::detail

namespace tapestry::raster {

template <std::floating_point T>
Array<T, 2> bake_atlas(const PaintedMesh& body, const Array<T, 2>& texels, const TextureLayout& to) {
  detail::require_bakeable("bake_atlas", body, texels);
  if (to.kind != TextureKind::atlas || to.height == 0 || to.width == 0 || !(to.u_extent > 0))
    throw DomainError("bake_atlas: expected the layout of an atlas with rows, columns and a u_extent");
  const SurfaceColour<T, PreparedUnlit> colour(body, texels, {});
  auto atlas = filled<T, 2>({to.height * to.width, 3}, T(0.5));
  auto used = zeros<T, 2>({to.height, to.width});
  for (const bool is_rim : {true, false}) {
    for (std::size_t face = 0; face < body.painted.size(); ++face) {
      if (body.painted[face] == 0) continue;
      for_each_atlas_texel(
          body.mesh, to, face, [&](std::size_t row, std::size_t column, const std::array<double, 3>& b) {
            if ((std::min({b[0], b[1], b[2]}) < 0) != is_rim) return;
            const auto value = colour.at(static_cast<std::int32_t>(face), detail::clamped_barycentric(b));
            for (std::size_t c = 0; c < 3; ++c) atlas(row * to.width + column, c) = static_cast<T>(value[c]);
            used(row, column) = T(1);
          });
    }
  }
  return with_unused_filled(to, used, atlas);
}

template <std::floating_point T>
Array<T, 2> bake_cube(const PaintedMesh& body, const Array<T, 2>& texels, const TextureLayout& to, T unused) {
  detail::require_bakeable("bake_cube", body, texels);
  if (to.kind != TextureKind::cube || to.texels_per_edge == 0 || to.texels_per_edge > 256)
    throw DomainError("bake_cube: expected the layout of a cube of 1 to 256 texels an edge");
  const SurfaceColour<T, PreparedUnlit> colour(body, texels, {});
  const std::size_t edge = to.texels_per_edge, count = edge * edge * edge;
  auto cube = filled<T, 2>({to.texel_count(body.mesh), 3}, unused);
  for (std::size_t face = 0; face < body.painted.size(); ++face) {
    if (body.painted[face] == 0) continue;
    for (std::size_t texel = 0; texel < count; ++texel) {
      const std::array<double, 3> at{static_cast<double>(texel / (edge * edge)),
                                     static_cast<double>(texel / edge % edge),
                                     static_cast<double>(texel % edge)};
      const auto value = colour.at(static_cast<std::int32_t>(face), detail::clamped_barycentric(at));
      for (std::size_t c = 0; c < 3; ++c) cube(face * count + texel, c) = static_cast<T>(value[c]);
    }
  }
  return cube;
}

template decltype(bake_atlas<float>) bake_atlas<float>;
template decltype(bake_atlas<double>) bake_atlas<double>;
template decltype(bake_cube<float>) bake_cube<float>;
template decltype(bake_cube<double>) bake_cube<double>;

}  // namespace tapestry::raster

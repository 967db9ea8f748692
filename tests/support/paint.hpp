#pragma once
#include <tapestry/raster/light.hpp>
#include <tapestry/raster/texture_layout.hpp>

namespace tapestry::test {
// One texture layout of each kind, small, and a light that shows all of its terms.
inline const auto atlas = raster::atlas_layout(8, 16, 2);
inline const auto trilinear = raster::atlas_layout(8, 16, 2, raster::TextureFilter::trilinear);
inline const auto anisotropic = raster::atlas_layout(8, 16, 2, raster::TextureFilter::anisotropic);
inline const auto cube = raster::cube_layout(3), vertex = raster::vertex_layout, solid = raster::solid_layout;
inline const raster::Light warm{0.3, 0.6, {0.2, -0.4, -1}, {1, 0.8, 0.6}};

/// Paints the whole mesh.
inline std::vector<std::uint8_t> every_face(const geometry::Mesh& mesh) {
  return std::vector<std::uint8_t>(mesh.faces.size(), 1);
}
}  // namespace tapestry::test

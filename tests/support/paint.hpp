#pragma once
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/raster/light.hpp>
#include <tapestry/raster/texture_layout.hpp>

namespace tapestry::test {

// One texture layout of each kind, small, and a light that shows all of its terms.
inline const raster::TextureLayout atlas{raster::TextureKind::atlas, 8, 16, 2, 0};
inline const raster::TextureLayout trilinear{raster::TextureKind::atlas,      8, 16, 2, 0,
                                             raster::TextureFilter::trilinear};
inline const raster::TextureLayout anisotropic{raster::TextureKind::atlas,        8, 16, 2, 0,
                                               raster::TextureFilter::anisotropic};
inline const raster::TextureLayout cube{raster::TextureKind::cube, 0, 0, 1, 3};
inline const raster::TextureLayout vertex{raster::TextureKind::vertex, 0, 0, 1, 0};
inline const raster::TextureLayout solid{raster::TextureKind::solid, 0, 0, 1, 0};
inline const raster::Light warm{0.3, 0.6, {0.2, -0.4, -1}, {1, 0.8, 0.6}};

/// Paints the whole mesh.
inline std::vector<std::uint8_t> every_face(const geometry::Mesh& mesh) {
  return std::vector<std::uint8_t>(mesh.faces.size(), 1);
}

}  // namespace tapestry::test

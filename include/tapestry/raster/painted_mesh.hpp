#pragma once
#include <cstdint>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/raster/texture_layout.hpp>
#include <vector>

namespace tapestry::raster {

/// A mesh and the faces of it that a texture covers; the others keep their material's colour.
struct PaintedMesh {
  geometry::Mesh mesh;
  std::vector<std::uint8_t> painted;  ///< one entry a face, 1 where the texture shows
  TextureLayout layout;               ///< of the texture, whose texels are an array of their own
};

}  // namespace tapestry::raster

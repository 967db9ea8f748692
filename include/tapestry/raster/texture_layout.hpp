#pragma once
#include <cstddef>
#include <tapestry/geometry/mesh.hpp>

namespace tapestry::raster {

/// atlas: one picture that the mesh's uv coordinates point into. cube: s³ texels for every face, looked
/// up by barycentric coordinates, as in Neural Mesh Renderer. vertex: a colour for every position of the
/// mesh, interpolated over its faces. solid: one colour for all that is painted.
enum class TextureKind { atlas, cube, vertex, solid };

/// How an atlas is looked up. bilinear: in the atlas itself. trilinear: between the two levels of its
/// pyramid whose texels are about as large as the pixel's footprint, see mip_pyramid().
enum class TextureFilter { bilinear, trilinear };

/// Where a texture's texels are; the texels themselves are an array [texel_count, 3].
struct TextureLayout {
  TextureKind kind = TextureKind::atlas;
  std::size_t height = 0;           ///< atlas: rows, row 0 on top (v = 1)
  std::size_t width = 0;            ///< atlas: columns
  double u_extent = 1;              ///< atlas: u in [0, u_extent] spans the width; 2 for the car's 2×1 atlas
  std::size_t texels_per_edge = 0;  ///< cube: s
  TextureFilter filter = TextureFilter::bilinear;  ///< of an atlas; ignored by the other kinds

  /// atlas: height · width, texel row · width + column; cube: F · s³, texel ((f·s + a)·s + b)·s + c;
  /// vertex: V, texel = position; solid: 1.
  [[nodiscard]] std::size_t texel_count(const geometry::Mesh& mesh) const {
    switch (kind) {
      case TextureKind::atlas:
        return height * width;
      case TextureKind::cube:
        return mesh.faces.size() * texels_per_edge * texels_per_edge * texels_per_edge;
      case TextureKind::vertex:
        return mesh.positions.size();
      case TextureKind::solid:
        break;
    }
    return 1;
  }
};

/// One texel's part in a lookup.
struct Tap {
  std::size_t texel;
  double weight;
};

}  // namespace tapestry::raster

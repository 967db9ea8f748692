#pragma once
#include <array>
#include <cstddef>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/geometry/mesh.hpp>

namespace tapestry::raster {

/// atlas: one picture that the mesh's uv coordinates point into. cube: s³ texels for every face, looked
/// up by barycentric coordinates, as in Neural Mesh Renderer. vertex: a colour for every position of the
/// mesh, interpolated over its faces. solid: one colour for all that is painted.
enum class TextureKind { atlas, cube, vertex, solid };

/// How an atlas is looked up. bilinear: in the atlas itself. trilinear: between the two levels of its
/// pyramid whose texels are about as large as the pixel's footprint is long, see MipPyramid. anisotropic:
/// trilinear, as large as the footprint is wide, at several places along it.
enum class TextureFilter { bilinear, trilinear, anisotropic };

/// All of them.
inline constexpr std::array texture_filters{TextureFilter::bilinear, TextureFilter::trilinear,
                                            TextureFilter::anisotropic};

/// As options and manifests call it.
[[nodiscard]] constexpr const char* name_of(TextureFilter filter) {
  if (filter == TextureFilter::bilinear) return "bilinear";
  return filter == TextureFilter::trilinear ? "trilinear" : "anisotropic";
}

/// \throws DomainError if no filter has that name
[[nodiscard]] inline TextureFilter texture_filter_by_name(const std::string& name) {
  for (const TextureFilter filter : texture_filters)
    if (name == name_of(filter)) return filter;
  throw DomainError("no texture filter " + in_quotes(name) + "; expected bilinear, trilinear or anisotropic");
}

/// Where a texture's texels are; the texels themselves are an array [texel_count, 3].
struct TextureLayout {
  TextureKind kind = TextureKind::atlas;
  std::size_t height = 0;           ///< atlas: rows, row 0 on top (v = 1)
  std::size_t width = 0;            ///< atlas: columns
  double u_extent = 1;              ///< atlas: u in [0, u_extent] spans the width; 2 for the car's 2×1 atlas
  std::size_t texels_per_edge = 0;  ///< cube: s
  TextureFilter filter = TextureFilter::bilinear;  ///< of an atlas; ignored by the other kinds
  std::size_t most_lookups = 8;  ///< anisotropic: places along a footprint, at most; 1 to 64

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

#pragma once
#include <tapestry/raster/detail/texture_kinds.hpp>
#include <tapestry/raster/painted_mesh.hpp>

namespace tapestry::raster {
/// A texture of any kind as an atlas. A texel that a painted face covers takes the texture's colour there; a
/// texel just outside a chart takes the colour of the chart's rim. A chart's texels count before another
/// chart's rim. Texels farther off take colours of the charts around them, see with_unused_filled().
///
/// \param texels  [texel_count, 3], in body.layout
/// \param to      layout of the atlas
/// \returns       [to.height · to.width, 3]; grey of 0.5 if no face is painted
/// \throws ShapeError, DomainError, Error (mismatch) as texture_operator() does; DomainError unless `to` is
///         an atlas
template <std::floating_point T>
[[nodiscard]] Array<T, 2> bake_atlas(const PaintedMesh& body, const Array<T, 2>& texels,
                                     const TextureLayout& to);

/// A texture of any kind as cubes: texel (a, b, c) takes the colour at the barycentric coordinates
/// (a, b, c) / (a + b + c), the centroid at (0, 0, 0). Source: Neural Mesh Renderer, load_textures, whose
/// division by 0 at that texel leaves NaN.
///
/// \param to  layout of the cubes
/// \returns   [F · s³, 3]; `unused` in faces that are not painted
/// \throws as bake_atlas(); DomainError unless `to` is a cube of 1 to 256 texels an edge
template <std::floating_point T>
[[nodiscard]] Array<T, 2> bake_cube(const PaintedMesh& body, const Array<T, 2>& texels,
                                    const TextureLayout& to, T unused = T(0.5));
}  // namespace tapestry::raster

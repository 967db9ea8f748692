#pragma once
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/raster/painted_mesh.hpp>

namespace tapestry::camouflage {
/// The colours that the painted faces have by their materials, as a texture, [texel, 3]. Atlas texels that
/// no painted face uses take the mean over painted faces.
template <class T>
[[nodiscard]] Array<T, 2> own_colours(const raster::PaintedMesh& car);

/// A texture as an atlas picture for a viewer, [H, W, 3] in [0, 1] with row 0 at v = 1: texels that no
/// painted face refers to take colours of those around them. Textures of other kinds than an atlas are baked
/// into one of 512 × 1024 texels; faces without uv do not show.
template <class T>
[[nodiscard]] Array<T, 3> atlas_of(const raster::PaintedMesh& car, const Array<T, 2>& colours);

}  // namespace tapestry::camouflage

#pragma once
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/raster/detail/fragment_shader.hpp>
#include <tapestry/raster/mip_pyramid.hpp>
#include <tapestry/raster/texture_layout.hpp>

namespace tapestry::raster {

/// Calls visit(row, column, barycentric) for every texel of the atlas whose centre is in the face's uv
/// triangle, or within half a texel's diagonal of it; bilinear lookups along the chart's border then find
/// paint. Visits no texel for a face without uv or without area in uv, and none outside the atlas.
template <class Visit>
void for_each_atlas_texel(const geometry::Mesh& mesh, const TextureLayout& layout, std::size_t face,
                          Visit visit) {
  std::array<std::array<double, 2>, 3> corner{};  // in texels: column, row
  for (std::size_t k = 0; k < 3; ++k) {
    const auto index = face < mesh.face_uvs.size() ? mesh.face_uvs[face][k] : -1;
    if (index < 0) return;
    const auto& uv = mesh.uvs[static_cast<std::size_t>(index)];
    corner[k] = {uv[0] / layout.u_extent * static_cast<double>(layout.width),
                 (1 - uv[1]) * static_cast<double>(layout.height)};
  }
  const auto cross = [](const auto& a, const auto& b, double x, double y) {
    return (b[0] - a[0]) * (y - a[1]) - (b[1] - a[1]) * (x - a[0]);
  };
  const double area = cross(corner[0], corner[1], corner[2][0], corner[2][1]);
  if (!(std::abs(area) > 1e-12)) return;
  const auto bounds = [&](std::size_t axis, std::size_t extent) {
    const auto [low, high] = std::minmax({corner[0][axis], corner[1][axis], corner[2][axis]});
    const auto last = static_cast<double>(extent);
    return std::array<std::size_t, 2>{static_cast<std::size_t>(std::clamp(std::floor(low - 1), 0.0, last)),
                                      static_cast<std::size_t>(std::clamp(std::ceil(high + 1), 0.0, last))};
  };
  const auto [left, right] = bounds(0, layout.width);
  const auto [top, bottom] = bounds(1, layout.height);
  for (std::size_t row = top; row < bottom; ++row)
    for (std::size_t column = left; column < right; ++column) {
      const double x = static_cast<double>(column) + 0.5;
      const double y = static_cast<double>(row) + 0.5;
      std::array<double, 3> weight{};
      bool near = true;
      for (std::size_t k = 0; k < 3; ++k) {
        const auto& a = corner[(k + 1) % 3];
        const auto& b = corner[(k + 2) % 3];
        const double signed_area = cross(a, b, x, y) * (area > 0 ? 1 : -1);
        near = near && signed_area >= -0.71 * std::hypot(b[0] - a[0], b[1] - a[1]);  // ½√2 texels outside
        weight[k] = cross(a, b, x, y) / area;
      }
      if (near) visit(row, column, weight);
    }
}

namespace detail {

/// Barycentric coordinates brought into the triangle.
std::array<double, 3> clamped_barycentric(std::array<double, 3> b);

}  // namespace detail

/// A texture of any kind as an atlas. A texel that a painted face covers takes the texture's colour there; a
/// texel just outside a chart takes that of the chart's rim. A chart's texels count before another chart's
/// rim. Texels farther off take colours of the charts around them, see with_unused_filled().
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

#pragma once
#include <tapestry/raster/texture_layout.hpp>

namespace tapestry::raster {
/// Derivatives of a colour with respect to some coordinates: [channel][coordinate].
template <std::size_t Coordinates>
using ColourSlope = std::array<std::array<double, Coordinates>, 3>;

/// ∂colour/∂(u, v) of visit_atlas_taps()'s bilinear lookup. At a texel's centre, where it jumps, it takes the
/// side of the greater index; beyond the outer texels' centres it is 0.
/// \param texels  [height · width, 3]
template <class Texels>
[[nodiscard]] ColourSlope<2> atlas_slope(const TextureLayout& layout, const Texels& texels,
                                         const std::array<double, 2>& uv) {
  const double u = detail::wrapped(uv[0], layout.u_extent) / layout.u_extent;
  const double v = detail::wrapped(uv[1], 1);
  const auto columns = static_cast<double>(layout.width), rows = static_cast<double>(layout.height);
  const detail::AxisTaps column(u * columns - 0.5, layout.width);
  const detail::AxisTaps row((1 - v) * rows - 0.5, layout.height);
  const bool moves_along_row = u * columns - 0.5 >= 0, moves_down = (1 - v) * rows - 0.5 >= 0;
  ColourSlope<2> slope{};
  for (std::size_t c = 0; c < 3; ++c) {
    const auto texel = [&](std::size_t i, std::size_t j) {
      return static_cast<double>(texels(i * layout.width + j, c));
    };
    const double upper = texel(row.first, column.second) - texel(row.first, column.first);
    const double lower = texel(row.second, column.second) - texel(row.second, column.first);
    const double left = texel(row.second, column.first) - texel(row.first, column.first);
    const double right = texel(row.second, column.second) - texel(row.first, column.second);
    if (moves_along_row)
      slope[c][0] = (upper * (1 - row.share) + lower * row.share) * columns / layout.u_extent;
    if (moves_down) slope[c][1] = -(left * (1 - column.share) + right * column.share) * rows;
  }
  return slope;
}

/// ∂colour/∂(b₀, b₁, b₂) of visit_cube_taps()'s lookup; 0 along a coordinate that is clamped.
/// \param texels  [F · s³, 3]
template <class Texels>
[[nodiscard]] ColourSlope<3> cube_slope(const TextureLayout& layout, const Texels& texels, std::size_t face,
                                        const std::array<double, 3>& barycentric) {
  const std::size_t edge = layout.texels_per_edge;
  const double last = static_cast<double>(edge) - 1;
  ColourSlope<3> slope{};
  if (edge < 2) return slope;
  std::array<std::size_t, 3> cell;
  std::array<double, 3> share;
  std::array<double, 3> scale;
  for (std::size_t k = 0; k < 3; ++k) {
    const double wanted = barycentric[k] * last, position = std::max(std::min(wanted, last - 1e-3), 0.0);
    cell[k] = static_cast<std::size_t>(position);
    share[k] = position - static_cast<double>(cell[k]);
    scale[k] = wanted >= 0 && wanted <= last - 1e-3 ? last : 0;
  }
  for (std::size_t corner = 0; corner < 8; ++corner) {
    std::size_t texel = face;
    std::array<double, 3> weight{}, sign{};
    for (std::size_t k = 0; k < 3; ++k) {
      const bool upper = ((corner >> k) & 1U) != 0;
      texel = texel * edge + cell[k] + (upper ? 1 : 0);
      weight[k] = upper ? share[k] : 1 - share[k];
      sign[k] = upper ? 1 : -1;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const double factor = sign[k] * scale[k] * weight[(k + 1) % 3] * weight[(k + 2) % 3];
      for (std::size_t c = 0; c < 3; ++c) slope[c][k] += factor * static_cast<double>(texels(texel, c));
    }
  }
  return slope;
}

/// ∂colour/∂(b₀, b₁, b₂) of visit_taps().
/// \param texels  [texel_count, 3]
template <class Texels>
[[nodiscard]] ColourSlope<3> texture_slope(const TextureLayout& layout, const geometry::Mesh& mesh,
                                           const Texels& texels, std::size_t face,
                                           const std::array<double, 3>& b) {
  ColourSlope<3> slope{};
  switch (layout.kind) {
    case TextureKind::atlas: {
      const ColourSlope<2> by_uv = atlas_slope(layout, texels, uv_of_point(mesh, face, b));
      for (std::size_t k = 0; k < 3; ++k) {
        const auto& [u, v] = mesh.uvs[static_cast<std::size_t>(mesh.face_uvs[face][k])];
        for (std::size_t c = 0; c < 3; ++c) slope[c][k] = by_uv[c][0] * u + by_uv[c][1] * v;
      }
      break;
    }
    case TextureKind::cube:
      return cube_slope(layout, texels, face, b);
    case TextureKind::vertex:
      for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t c = 0; c < 3; ++c)
          slope[c][k] = static_cast<double>(texels(static_cast<std::size_t>(mesh.faces[face][k]), c));
      break;
    case TextureKind::solid:
      break;
  }
  return slope;
}

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

/// Calls visit(texel, b) for the texels that lie on a face, by the barycentric coordinates of their places.
/// atlas: see for_each_atlas_texel(). cube: texel (a, b, c) of s³ lies at (a, b, c) / (a + b + c), (0, 0, 0)
/// at the centroid. vertex: the corners. A solid colour has no place.
template <class Visit>
void for_each_texel_on(const TextureLayout& layout, const geometry::Mesh& mesh, std::size_t face,
                       Visit visit) {
  const std::size_t edge = layout.texels_per_edge, count = edge * edge * edge;
  switch (layout.kind) {
    case TextureKind::atlas:
      return for_each_atlas_texel(mesh, layout, face,
                                  [&](std::size_t row, std::size_t column, const std::array<double, 3>& b) {
                                    visit(row * layout.width + column, b);
                                  });
    case TextureKind::cube:
      for (std::size_t texel = 0; texel < count; ++texel)
        visit(face * count + texel, detail::clamped_barycentric({static_cast<double>(texel / (edge * edge)),
                                                                 static_cast<double>(texel / edge % edge),
                                                                 static_cast<double>(texel % edge)}));
      return;
    case TextureKind::vertex:
      for (std::size_t k = 0; k < 3; ++k)
        visit(static_cast<std::size_t>(mesh.faces[face][k]),
              std::array<double, 3>{k == 0 ? 1.0 : 0.0, k == 1 ? 1.0 : 0.0, k == 2 ? 1.0 : 0.0});
      return;
    case TextureKind::solid:
      return;
  }
}

/// Two sides of a parallelogram, in uv.
using UvSides = std::array<std::array<double, 2>, 2>;

/// Sides along two edges of a face, `share` of them long.
[[nodiscard]] inline UvSides sides_on(const geometry::Mesh& mesh, std::size_t face, double share) {
  return {uv_of_point(mesh, face, {-share, share, 0}), uv_of_point(mesh, face, {-share, 0, share})};
}

/// Sides of a texel on a face that has texture coordinates; of length 0 except for atlas and cube.
[[nodiscard]] inline UvSides texel_sides(const TextureLayout& layout, const geometry::Mesh& mesh,
                                         std::size_t face) {
  switch (layout.kind) {
    case TextureKind::atlas:
      return {{{layout.u_extent / static_cast<double>(layout.width), 0},
               {0, 1 / static_cast<double>(layout.height)}}};
    case TextureKind::cube:
      return sides_on(mesh, face,
                      1 / static_cast<double>(std::max<std::size_t>(layout.texels_per_edge, 2) - 1));
    case TextureKind::vertex:
    case TextureKind::solid:
      break;
  }
  return {};
}
}  // namespace tapestry::raster

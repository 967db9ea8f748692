#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <tapestry/camouflage/view.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>

namespace tapestry::camouflage {
namespace detail {
/// Calls visit(row, column, barycentric) for every texel of the atlas whose centre lies in the face's uv
/// triangle or within half a texel of it, so that bilinear lookups along the chart's border find paint.
template <class Visit>
void for_each_atlas_texel(const geometry::Mesh& mesh, const raster::TextureLayout& layout, std::size_t face,
                          Visit visit) {
  std::array<std::array<double, 2>, 3> corner{};  // in texels: column, row
  for (std::size_t k = 0; k < 3; ++k) {
    const auto index = mesh.face_uvs[face][k];
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

inline std::array<float, 3> face_colour(const geometry::Mesh& mesh, std::size_t face) {
  const auto material = mesh.face_materials.empty() ? -1 : mesh.face_materials[face];
  return material < 0 ? geometry::Material{}.colour
                      : mesh.materials[static_cast<std::size_t>(material)].colour;
}

/// The cube texel nearest to a barycentric position: a·s² + b·s + c with (a, b, c) = w · (s − 1).
inline std::size_t nearest_cube_texel(const raster::TextureLayout& layout, std::size_t face,
                                      const std::array<double, 3>& weight) {
  const std::size_t s = layout.texels_per_edge;
  std::size_t index = face;
  for (const double w : weight) {
    const double position = std::clamp(w, 0.0, 1.0) * static_cast<double>(s - 1);
    index = index * s + static_cast<std::size_t>(std::lround(position));
  }
  return index;
}
}  // namespace detail

/// The colours that the painted faces have by their materials, as a texture, [texel, 3]. Atlas texels that
/// no painted face uses take the mean over painted faces.
template <class T>
[[nodiscard]] Array<T, 2> own_colours(const PaintedMesh& car) {
  std::array<double, 3> sum{};
  double count = 0;
  for (std::size_t face = 0; face < car.painted.size(); ++face) {
    if (car.painted[face] == 0) continue;
    const auto colour = detail::face_colour(car.mesh, face);
    for (std::size_t c = 0; c < 3; ++c) sum[c] += static_cast<double>(colour[c]);
    ++count;
  }
  Array<T, 2> colours(Extents<2>{car.layout.texel_count(car.mesh), 3});
  for (std::size_t i = 0; i < colours.size(); ++i)
    colours.data()[i] = static_cast<T>(count > 0 ? sum[i % 3] / count : 0.5);
  for (std::size_t face = 0; face < car.painted.size(); ++face) {
    if (car.painted[face] == 0) continue;
    const auto colour = detail::face_colour(car.mesh, face);
    const auto paint = [&](std::size_t texel) {
      for (std::size_t c = 0; c < 3; ++c) colours(texel, c) = static_cast<T>(colour[c]);
    };
    if (car.layout.kind == raster::TextureKind::atlas) {
      detail::for_each_atlas_texel(car.mesh, car.layout, face,
                                   [&](std::size_t row, std::size_t column, const std::array<double, 3>&) {
                                     paint(row * car.layout.width + column);
                                   });
    } else {
      const std::size_t texels =
          car.layout.texels_per_edge * car.layout.texels_per_edge * car.layout.texels_per_edge;
      for (std::size_t texel = face * texels; texel < (face + 1) * texels; ++texel) paint(texel);
    }
  }
  return colours;
}

/// A texture as an atlas picture, [H, W, 3] in [0, 1] with row 0 at v = 1; 2:1 as the car's uv. A cube
/// texture is looked up at each atlas texel; faces without uv do not show.
template <class T>
[[nodiscard]] Array<T, 3> atlas_of(const PaintedMesh& car, const Array<T, 2>& colours) {
  const bool is_atlas = car.layout.kind == raster::TextureKind::atlas;
  auto layout = car.layout;
  if (!is_atlas) {
    layout.height = 512;
    layout.width = 1024;
  }
  auto picture = filled<T, 3>({layout.height, layout.width, 3}, T(0.5));
  if (is_atlas) {
    std::copy_n(colours.data(), colours.size(), picture.data());
    return picture;
  }
  for (std::size_t face = 0; face < car.painted.size(); ++face) {
    if (car.painted[face] == 0 || car.mesh.face_uvs.empty()) continue;
    detail::for_each_atlas_texel(
        car.mesh, layout, face,
        [&](std::size_t row, std::size_t column, const std::array<double, 3>& weight) {
          const std::size_t texel = detail::nearest_cube_texel(layout, face, weight);
          std::copy_n(&colours(texel, 0), 3, &picture(row, column, 0));
        });
  }
  return picture;
}

}  // namespace tapestry::camouflage

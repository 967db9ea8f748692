#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <tapestry/camouflage/own_colours.hpp>
#include <tapestry/camouflage/view.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/raster/bake.hpp>
#include <tapestry/raster/mip_pyramid.hpp>
#include <tapestry/raster/used_texels.hpp>

namespace tapestry::camouflage {

template <class T>
Array<T, 2> own_colours(const raster::PaintedMesh& car) {
  std::array<double, 3> sum{};
  double count = 0;
  for (std::size_t face = 0; face < car.painted.size(); ++face) {
    if (car.painted[face] == 0) continue;
    const auto colour = geometry::material_colour(car.mesh, face);
    for (std::size_t c = 0; c < 3; ++c) sum[c] += static_cast<double>(colour[c]);
    ++count;
  }
  Array<T, 2> colours(Extents<2>{car.layout.texel_count(car.mesh), 3});
  for (std::size_t i = 0; i < colours.size(); ++i)
    colours.data()[i] = static_cast<T>(count > 0 ? sum[i % 3] / count : 0.5);
  for (std::size_t face = 0; face < car.painted.size(); ++face) {
    if (car.painted[face] == 0) continue;
    const auto colour = geometry::material_colour(car.mesh, face);
    const auto paint = [&](std::size_t texel) {
      for (std::size_t c = 0; c < 3; ++c) colours(texel, c) = static_cast<T>(colour[c]);
    };
    if (car.layout.kind == raster::TextureKind::atlas) {
      raster::for_each_atlas_texel(car.mesh, car.layout, face,
                                   [&](std::size_t row, std::size_t column, const std::array<double, 3>&) {
                                     paint(row * car.layout.width + column);
                                   });
    } else if (car.layout.kind == raster::TextureKind::vertex) {
      for (const std::int32_t corner : car.mesh.faces[face]) paint(static_cast<std::size_t>(corner));
    } else {
      const std::size_t texels =
          car.layout.texels_per_edge * car.layout.texels_per_edge * car.layout.texels_per_edge;
      for (std::size_t texel = face * texels; texel < (face + 1) * texels; ++texel) paint(texel);
    }
  }
  return colours;
}

template <class T>
Array<T, 3> atlas_of(const raster::PaintedMesh& car, const Array<T, 2>& colours) {
  const bool is_atlas = car.layout.kind == raster::TextureKind::atlas;
  const raster::TextureLayout layout =
      is_atlas ? car.layout
               : raster::TextureLayout{raster::TextureKind::atlas, 512, 1024, car.layout.u_extent};
  const auto texels = is_atlas
                          ? raster::with_unused_filled(layout, raster::used_texels_or_all<T>(car), colours)
                          : raster::bake_atlas(car, colours, layout);
  Array<T, 3> picture(Extents<3>{layout.height, layout.width, 3});
  std::copy_n(texels.data(), texels.size(), picture.data());
  return picture;
}

template decltype(own_colours<float>) own_colours<float>;
template decltype(own_colours<double>) own_colours<double>;
template decltype(atlas_of<float>) atlas_of<float>;
template decltype(atlas_of<double>) atlas_of<double>;

}  // namespace tapestry::camouflage

#pragma once
#include <tapestry/camouflage/paint.hpp>
#include <tapestry/camouflage/view.hpp>
#include <tapestry/raster/bake.hpp>
#include <tapestry/raster/face_charts.hpp>
#include <tapestry/raster/used_texels.hpp>

namespace tapestry::camouflage {

template <std::floating_point T>
Paint<T> without_paint(Array<T, 2> colours) {
  std::vector<std::uint8_t> painted(colours.shape(0), 0);
  return {std::move(colours), std::move(painted)};
}

template <std::floating_point T>
void require_sound(const char* operation, const Paint<T>& paint) {
  if (!paint.painted.empty() && paint.painted.size() != paint.colours.shape(0))
    throw ShapeError({operation, ": ", paint.painted.size(), " texels are paint or not, expected ",
                      paint.colours.shape(0)});
}

template <std::floating_point T>
Array<T, 2> printed(const Paint<T>& paint, const image::ColourChange& print) {
  require_sound("printed", paint);
  const auto& [colours, painted] = paint;
  auto result = image::transformed(colours, print);
  for (std::size_t texel = 0; texel < painted.size(); ++texel)
    for (std::size_t c = 0; c < 3 && painted[texel] == 0; ++c) result(texel, c) = colours(texel, c);
  return result;
}

template <std::floating_point T>
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
  if (car.layout.kind == raster::TextureKind::solid) return colours;
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

template <std::floating_point T>
Array<T, 3> atlas_of(const raster::PaintedMesh& car, const Array<T, 2>& colours) {
  const auto texels = [&] {
    if (car.layout.kind == raster::TextureKind::atlas)
      return raster::with_unused_filled(car.layout, raster::used_texels_or_all<T>(car), colours);
    raster::PaintedMesh charted = raster::with_atlas(car);
    const raster::TextureLayout layout = std::exchange(charted.layout, car.layout);
    const auto baked = raster::bake_atlas(charted, image::in_space(car.space, colours), layout);
    return car.space == image::ColourSpace::linear ? image::encoded(baked) : baked;
  }();
  const auto layout = raster::with_atlas(car).layout;
  Array<T, 3> picture(Extents<3>{layout.height, layout.width, 3});
  std::copy_n(texels.data(), texels.size(), picture.data());
  return picture;
}

template <std::floating_point T>
Array<T, 2> parameter_of_colours(const Array<T, 2>& colours) {
  Array<T, 2> parameter(colours.shape());
  for (std::size_t i = 0; i < colours.size(); ++i) {
    const T c = std::clamp(colours.data()[i], T(colour_margin), T(1 - colour_margin));
    parameter.data()[i] = std::atanh(T(2) * c - T(1));
  }
  return parameter;
}

template <std::floating_point T>
Array<T, 2> random_colours(std::size_t texel_count, Random& random) {
  Array<T, 2> colours(Extents<2>{texel_count, 3});
  for (T& value : colours.storage()) value = static_cast<T>(random.uniform(0.02, 0.98));
  return colours;
}

template <std::floating_point T>
Array<T, 2> solid_colours(std::size_t texel_count, const std::array<double, 3>& colour) {
  Array<T, 2> colours(Extents<2>{texel_count, 3});
  for (std::size_t i = 0; i < colours.size(); ++i) colours.data()[i] = static_cast<T>(colour[i % 3]);
  return colours;
}

}  // namespace tapestry::camouflage

#pragma once
#include <tapestry/camouflage/paint.hpp>
#include <tapestry/raster/bake.hpp>
#include <tapestry/raster/face_charts.hpp>
#include <tapestry/raster/mesh_pictures.hpp>

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

namespace detail {
/// Own colour of a face around a point: its picture's mean over the parallelogram of sides(), or its
/// material's colour.
template <std::invocable Sides>
std::array<float, 3> own_colour(const raster::PaintedMesh& car, std::size_t face,
                                const std::array<double, 3>& barycentric, Sides sides) {
  const auto* const picture = raster::picture_of_face(car, face);
  if (picture == nullptr) return geometry::material_colour(car.mesh, face);
  const auto middle = raster::uv_of_point(car.mesh, face, barycentric);
  return raster::mean_colour(*picture, car.space, middle, sides());
}
}  // namespace detail

template <std::floating_point T>
Array<T, 2> own_colours(const raster::PaintedMesh& car) {
  std::array<double, 3> sum{};
  double count = 0;
  for (std::size_t face = 0; face < car.painted.size(); ++face) {
    if (car.painted[face] == 0) continue;
    const auto colour = detail::own_colour(car, face, {1.0 / 3, 1.0 / 3, 1.0 / 3},
                                           [&] { return raster::sides_on(car.mesh, face, 0.5); });
    for (std::size_t c = 0; c < 3; ++c) sum[c] += static_cast<double>(colour[c]);
    ++count;
  }
  Array<T, 2> colours(Extents<2>{car.layout.texel_count(car.mesh), 3});
  for (std::size_t i = 0; i < colours.size(); ++i)
    colours.data()[i] = static_cast<T>(count > 0 ? sum[i % 3] / count : 0.5);
  for (std::size_t face = 0; face < car.painted.size(); ++face) {
    if (car.painted[face] == 0) continue;
    const auto sides = [&] { return raster::texel_sides(car.layout, car.mesh, face); };
    raster::for_each_texel_on(car.layout, car.mesh, face, [&](std::size_t texel, const auto& barycentric) {
      const auto colour = detail::own_colour(car, face, barycentric, sides);
      for (std::size_t c = 0; c < 3; ++c) colours(texel, c) = static_cast<T>(colour[c]);
    });
  }
  return colours;
}

template <std::floating_point T>
Array<T, 3> atlas_of(const raster::PaintedMesh& car, const Array<T, 2>& colours) {
  const auto texels = [&] {
    if (car.layout.traits().is_picture)
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

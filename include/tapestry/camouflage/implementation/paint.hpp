#pragma once
#include <tapestry/camouflage/paint.hpp>
#include <tapestry/camouflage/view.hpp>
#include <tapestry/raster/bake.hpp>
#include <tapestry/raster/face_charts.hpp>
#include <tapestry/raster/mesh_pictures.hpp>
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

namespace detail {

/// Own colour of a face around a point: its picture's mean over a parallelogram, whose sides run along two
/// edges of the face and are `share` of them long, or its material's colour.
inline std::array<float, 3> own_colour(const raster::PaintedMesh& car, std::size_t face,
                                       const std::array<double, 3>& barycentric, double share) {
  const auto* const picture = raster::picture_of_face(car, face);
  if (picture == nullptr) return geometry::material_colour(car.mesh, face);
  std::array<std::array<double, 2>, 2> sides{};
  for (std::size_t side = 0; side < 2; ++side)
    sides[side] = raster::uv_of_point(car.mesh, face, {-share, side == 0 ? share : 0, side == 0 ? 0 : share});
  const auto middle = raster::uv_of_point(car.mesh, face, barycentric);
  return raster::mean_colour(*picture, car.space, middle, sides);
}

/// Calls visit(texel, colour) for the texels of a face: an atlas's texel takes the mean over its square in
/// uv, a cube's the mean around the point whose barycentric coordinates have the ratios of its indices, a
/// vertex's the colour there.
template <class Visit>
void for_each_own_texel(const raster::PaintedMesh& car, std::size_t face, Visit visit) {
  const auto& layout = car.layout;
  const auto* const picture = raster::picture_of_face(car, face);
  if (layout.kind == raster::TextureKind::atlas) {
    const std::array<std::array<double, 2>, 2> texel{
        {{layout.u_extent / static_cast<double>(layout.width), 0},
         {0, 1 / static_cast<double>(layout.height)}}};
    raster::for_each_atlas_texel(
        car.mesh, layout, face, [&](std::size_t row, std::size_t column, const auto& b) {
          visit(row * layout.width + column,
                picture
                    ? raster::mean_colour(*picture, car.space, raster::uv_of_point(car.mesh, face, b), texel)
                    : geometry::material_colour(car.mesh, face));
        });
  } else if (layout.kind == raster::TextureKind::vertex) {
    for (std::size_t k = 0; k < 3; ++k) {
      std::array<double, 3> corner{};
      corner[k] = 1;
      visit(static_cast<std::size_t>(car.mesh.faces[face][k]), own_colour(car, face, corner, 0));
    }
  } else {
    const std::size_t edge = layout.texels_per_edge, count = edge * edge * edge;
    const double share = edge > 1 ? 1 / static_cast<double>(edge - 1) : 1;
    for (std::size_t texel = 0; texel < count; ++texel) {
      std::array<double, 3> b{static_cast<double>(texel / (edge * edge)),
                              static_cast<double>(texel / edge % edge), static_cast<double>(texel % edge)};
      const double sum = b[0] + b[1] + b[2];
      for (double& weight : b) weight = sum > 0 ? weight / sum : 1.0 / 3;
      visit(face * count + texel, own_colour(car, face, b, share));
    }
  }
}

}  // namespace detail

template <std::floating_point T>
Array<T, 2> own_colours(const raster::PaintedMesh& car) {
  std::array<double, 3> sum{};
  double count = 0;
  for (std::size_t face = 0; face < car.painted.size(); ++face) {
    if (car.painted[face] == 0) continue;
    const auto colour = detail::own_colour(car, face, {1.0 / 3, 1.0 / 3, 1.0 / 3}, 0.5);
    for (std::size_t c = 0; c < 3; ++c) sum[c] += static_cast<double>(colour[c]);
    ++count;
  }
  Array<T, 2> colours(Extents<2>{car.layout.texel_count(car.mesh), 3});
  for (std::size_t i = 0; i < colours.size(); ++i)
    colours.data()[i] = static_cast<T>(count > 0 ? sum[i % 3] / count : 0.5);
  if (car.layout.kind == raster::TextureKind::solid) return colours;
  for (std::size_t face = 0; face < car.painted.size(); ++face)
    if (car.painted[face] != 0)
      detail::for_each_own_texel(car, face, [&](std::size_t texel, const std::array<float, 3>& colour) {
        for (std::size_t c = 0; c < 3; ++c) colours(texel, c) = static_cast<T>(colour[c]);
      });
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

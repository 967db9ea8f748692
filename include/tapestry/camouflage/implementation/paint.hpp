#pragma once
#include <tapestry/camouflage/paint.hpp>
#include <tapestry/camouflage/view.hpp>
#include <tapestry/io/npy.hpp>
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

template decltype(without_paint<float>) without_paint<float>;
template decltype(without_paint<double>) without_paint<double>;
template void require_sound<float>(const char* operation, const Paint<float>& paint);
template void require_sound<double>(const char* operation, const Paint<double>& paint);
template Array<float, 2> printed<float>(const Paint<float>& paint, const image::ColourChange& print);
template Array<double, 2> printed<double>(const Paint<double>& paint, const image::ColourChange& print);

}  // namespace tapestry::camouflage

namespace tapestry::camouflage::detail {

/// \throws FileError (mismatch) with the text `wrong`, unless an array of a file is [count, 3]
inline void require_rows_of_3(const std::string& path, const char* wrong, std::size_t count,
                              const Array<float, 2>& found) {
  if (found.shape(0) == count && found.shape(1) == 3) return;
  throw FileError(ErrorKind::mismatch,
                  {path, "", wrong, io::shape_text(std::vector<std::size_t>{count, 3}),
                   io::shape_text(std::vector<std::size_t>{found.shape(0), found.shape(1)})});
}

}  // namespace tapestry::camouflage::detail

namespace tapestry::camouflage {

Paint<float> read_paint(const std::string& path, std::size_t texel_count) {
  const auto file = io::NpzFile::read(path);
  Paint<float> paint{file.array<float, 2>("colours")};
  const auto& colours = paint.colours;
  detail::require_rows_of_3(path, "the texture does not fit the car", texel_count, colours);
  for (std::size_t i = 0; i < colours.size(); ++i)
    if (!(colours.data()[i] >= 0 && colours.data()[i] <= 1))
      throw FileError(ErrorKind::malformed, {path, "", "colour " + std::to_string(i), "a number in 0 to 1",
                                             std::to_string(colours.data()[i])});
  if (!file.has("painted")) return paint;
  const auto painted = file.array<std::uint8_t, 1>("painted");
  if (painted.size() != texel_count)
    throw FileError(ErrorKind::mismatch, {path, "", "painted does not fit the car",
                                          io::shape_text(std::vector<std::size_t>{texel_count}),
                                          io::shape_text(std::vector<std::size_t>{painted.size()})});
  for (std::size_t i = 0; i < painted.size(); ++i)
    if (painted(i) > 1)
      throw FileError(ErrorKind::malformed, {path, "", "painted, texel " + std::to_string(i), "0 or 1",
                                             std::to_string(painted(i))});
  if (std::ranges::find(painted.storage(), 0) != painted.storage().end())
    paint.painted.assign(painted.begin(), painted.end());
  return paint;
}

Array<float, 2> read_offsets(const std::string& path, std::size_t position_count) {
  const auto file = io::NpzFile::read(path);
  if (!file.has("offsets")) return {};
  auto offsets = file.array<float, 2>("offsets");
  detail::require_rows_of_3(path, "the shape does not fit the car", position_count, offsets);
  for (std::size_t i = 0; i < offsets.size(); ++i)
    if (!(std::abs(offsets.data()[i]) <= 1))
      throw FileError(ErrorKind::malformed, {path, "", "offset " + std::to_string(i), "a number in -1 to 1",
                                             std::to_string(offsets.data()[i])});
  return offsets;
}

void write_paint(const std::string& path, const Array<float, 2>& parameter, const Paint<float>& paint,
                 const Array<float, 2>& offsets, const std::string& layout) {
  require_sound("write_paint", paint);
  Array<std::uint8_t, 1> painted = filled<std::uint8_t, 1>({paint.colours.shape(0)}, 1);
  std::copy(paint.painted.begin(), paint.painted.end(), painted.begin());
  io::NpzWriter file;
  file.add("parameter", parameter);
  file.add("colours", paint.colours);
  file.add("painted", painted);
  if (offsets.size() > 0) file.add("offsets", offsets);
  if (!layout.empty()) file.add("layout", std::string_view(layout));
  file.write(path);
}

std::string read_layout(const std::string& path) {
  const auto file = io::NpzFile::read(path);
  if (!file.has("layout")) return {};
  const auto text = file.get("layout").as<std::uint8_t>();
  return {text.begin(), text.end()};
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

template decltype(own_colours<float>) own_colours<float>;
template decltype(own_colours<double>) own_colours<double>;
template decltype(atlas_of<float>) atlas_of<float>;
template decltype(atlas_of<double>) atlas_of<double>;

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

template decltype(parameter_of_colours<float>) parameter_of_colours<float>;
template decltype(parameter_of_colours<double>) parameter_of_colours<double>;
template decltype(random_colours<float>) random_colours<float>;
template decltype(random_colours<double>) random_colours<double>;
template decltype(solid_colours<float>) solid_colours<float>;
template decltype(solid_colours<double>) solid_colours<double>;

}  // namespace tapestry::camouflage

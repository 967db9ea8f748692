#pragma once
#include <tapestry/raster/bake.hpp>
#include "inputs.hpp"
#include "own_texture.hpp"
#include "program.hpp"

namespace tapestry::shell {
/// A measured camouflage: the result of a run, or any picture that lies on the mesh by its uv. With neither
/// only the plain car is measured.
struct CamouflageSource {
  std::string run{}, picture{};

  [[nodiscard]] bool is_given() const { return !run.empty() || !picture.empty(); }
};

/// Means of a picture along an axis over `count` equal parts of a stretch of it; beyond its end it repeats.
/// \param stretch  in lengths of the picture's axis
inline Array<float, 3> means_along(const Array<float, 3>& picture, std::size_t axis, std::size_t count,
                                   double stretch) {
  auto extents = picture.shape();
  const auto length = static_cast<double>(extents[axis]);
  extents[axis] = count;
  auto means = zeros<float, 3>(extents);
  for (std::size_t part = 0; part < count; ++part) {
    const double begin = length * stretch * static_cast<double>(part) / static_cast<double>(count);
    const double end = length * stretch * static_cast<double>(part + 1) / static_cast<double>(count);
    for (double at = std::floor(begin); at < end; ++at) {
      const auto weight = static_cast<float>((std::min(end, at + 1) - std::max(begin, at)) / (end - begin));
      const auto source = static_cast<std::size_t>(std::fmod(at, length));
      for (std::size_t other = 0; other < picture.shape(1 - axis); ++other)
        for (std::size_t c = 0; c < 3; ++c)
          if (axis == 0)
            means(part, other, c) += weight * picture(source, other, c);
          else
            means(other, part, c) += weight * picture(other, source, c);
    }
  }
  return means;
}

/// Root of the mean square of the differences of two arrays, over the entries that count.
template <class Values, class IsCounted>
double difference_of(const Values& one, const Values& other, IsCounted is_counted) {
  double sum = 0, count = 0;
  for (std::size_t i = 0; i < one.size(); ++i)
    if (is_counted(i)) sum += std::pow(static_cast<double>(one.data()[i] - other.data()[i]), 2), ++count;
  return std::sqrt(sum / count);
}

/// \throws FileError (mismatch) if the painted faces have the paint as their own texture, so that the car in
///         its own colours would wear it: as a picture, in 32 x 32 parts, or on the mesh, in its texels
inline void require_other_than_own(const std::string& path, const Bitmap& picture,
                                   const Array<float, 2>& colours, const Car& car,
                                   const std::string& mesh_path) {
  constexpr double most = 0.01;  // of compression and resampling
  const auto& body = car.painted;
  std::set<std::string> textures;
  for (std::size_t face = 0; face < body.painted.size(); ++face)
    if (body.painted[face] != 0) textures.insert(texture_of(body.mesh, face));
  textures.erase("");
  if (textures.empty()) return;
  std::vector<bool> shown(colours.size());  // shown at a texel's centre: others may mix faces
  for (std::size_t face = 0; face < body.painted.size(); ++face)
    if (body.painted[face] != 0)
      raster::for_each_atlas_texel(
          body.mesh, body.layout, face, [&](std::size_t row, std::size_t column, const auto& barycentric) {
            if (std::ranges::min(barycentric) >= 0)
              std::fill_n(shown.begin() + static_cast<long>(3 * (row * body.layout.width + column)), 3, true);
          });
  bool is_same = difference_of(camouflage::own_colours<float>(body), colours,
                               [&](std::size_t i) { return shown[i]; }) <= most;
  const auto small = [](const Bitmap& bitmap) {
    return means_along(means_along(image::from_bytes<float>(bitmap), 0, 32, 1), 1, 32, 1);
  };
  const auto small_paint = small(picture);
  for (const std::string& texture : textures) {
    std::vector<std::string> told_before;
    const auto own = small(io::read_texture(texture, &told_before));
    is_same = is_same || difference_of(own, small_paint, [](std::size_t) { return true; }) <= most;
    if (!is_same) continue;
    const std::string file = car.material_files.empty() ? "the material file" : car.material_files.front();
    throw file_mismatch({mesh_path, "",
                         file + " gives painted faces the texture " + texture +
                             " (map_Kd), which is the paint " + path + ": the clean car would wear it",
                         "a material file with the car's own colours", ""});
  }
}

/// A picture as the paint of a car with an atlas, each texel the mean, in the car's colour space, of its part
/// of the picture. The picture repeats along u.
/// \throws FileError as io::read_texture(), read_texture_description() and require_other_than_own()
inline camouflage::Paint<float> picture_paint(const std::string& path, const Car& loaded,
                                              const std::string& mesh_path) {
  const raster::PaintedMesh& car = loaded.painted;
  std::vector<std::string> warnings;
  const auto picture = io::read_texture(path, &warnings);
  const auto description = read_texture_description(path, {picture.shape(0), picture.shape(1)});
  if (!description) remark(path + ": no description beside it; assumed: its width is 1 in u");
  const auto& layout = car.layout;
  const double width = description ? (*description)["u_extent"].get<double>() : 1;
  if (layout.height < picture.shape(0))
    warnings.push_back(path + ": its " + std::to_string(picture.shape(0)) + " rows are averaged to the " +
                       std::to_string(layout.height) + " of the atlas; --texels " +
                       std::to_string(picture.shape(0)) + " keeps them");
  print_warnings(warnings);
  const auto light = image::in_space(car.space, image::from_bytes<float>(picture));
  const auto texels =
      means_along(means_along(light, 0, layout.height, 1), 1, layout.width, layout.u_extent / width);
  camouflage::Paint<float> paint{Array<float, 2>(Extents<2>{layout.height * layout.width, 3})};
  const auto encoded = car.space == image::ColourSpace::linear ? image::encoded(texels) : texels;
  std::copy(encoded.begin(), encoded.end(), paint.colours.begin());
  require_other_than_own(path, picture, paint.colours, loaded, mesh_path);
  return paint;
}

/// \pre source.is_given()
/// \param mesh_path  the car's, for messages
/// \throws FileError as read_fitting_paint() or picture_paint()
inline camouflage::Paint<float> read_camouflage(const CamouflageSource& source, const Car& car,
                                                const std::string& mesh_path) {
  const io::InputLedger::Role role(camouflage_role);
  if (!source.picture.empty()) return picture_paint(source.picture, car, mesh_path);
  return read_fitting_paint(source.run + "/texture.npz", car.painted, car.description);
}

/// Offsets of the car's positions by a run that has optimised its shape; else empty.
inline Array<float, 2> read_offsets_of(const CamouflageSource& source, const raster::PaintedMesh& car) {
  if (source.run.empty()) return {};
  return camouflage::read_offsets(source.run + "/texture.npz", car.mesh.positions.size());
}
}  // namespace tapestry::shell

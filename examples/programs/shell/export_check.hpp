#pragma once
#include <tapestry/io/obj_file.hpp>
#include "own_texture.hpp"
#include "report.hpp"

namespace tapestry::shell {
/// A painted car that was exported, as a reader of its files finds it.
struct ExportedCar {
  raster::PaintedMesh car;
  Array<float, 2> colours;  ///< [texel, 3]
};

/// Reads a painted OBJ file back: the faces with the texture of its name are the painted ones, others may
/// have pictures of their own.
/// \param like  gives filter and colour space, which an OBJ file does not hold
inline ExportedCar read_exported_car(const std::string& obj, const raster::PaintedMesh& like) {
  ExportedCar exported{{io::read_obj(obj).mesh, {}, like.layout, like.space}, {}};
  auto& car = exported.car;
  const auto texture = io::path_of(obj).replace_extension(".png");
  for (const std::int32_t material : car.mesh.face_materials) {
    const bool is_paint =
        material >= 0 &&
        io::path_of(car.mesh.materials[static_cast<std::size_t>(material)].texture).filename() ==
            texture.filename();
    car.painted.push_back(is_paint ? 1 : 0);
  }
  const auto atlas = image::from_bytes<float>(io::read_texture(texture.string()));
  car.layout = raster::atlas_layout(atlas.shape(0), atlas.shape(1), 1,  // the writer divides u by the extent
                                    like.layout.filter);
  car.pyramid = raster::pyramid_of(car);
  std::vector<std::string> told_before;
  car.pictures = pictures_of(own_textures(car.mesh, told_before), car.mesh, car.layout.filter, car.space);
  exported.colours = Array<float, 2>(Extents<2>{atlas.shape(0) * atlas.shape(1), 3});
  std::copy_n(atlas.data(), atlas.size(), exported.colours.data());
  return exported;
}

/// Compares two pictures of a view, [H, W, 3], over those pixels that show the car and is_counted(pixel), an
/// index into the view's window.
template <std::predicate<std::size_t> IsCounted = bool (*)(std::size_t)>
PictureDifference difference_over_car(
    const Array<float, 3>& picture, const Array<float, 3>& other, const camouflage::View<float>& view,
    IsCounted is_counted = [](std::size_t) { return true; }) {
  const auto& coverage = view.paint_to_picture->coverage;
  PictureDifference difference;
  double count = 0;
  for (std::size_t y = 0; y < coverage.shape(0); ++y)
    for (std::size_t x = 0; x < coverage.shape(1); ++x)
      for (std::size_t c = 0; c < 3 && coverage(y, x) > 0 && is_counted(y * coverage.shape(1) + x); ++c) {
        const std::size_t row = view.window.top + y, column = view.window.left + x;
        const double step = std::abs(static_cast<double>(picture(row, column, c) - other(row, column, c)));
        difference.mean += step;
        difference.largest = std::max(difference.largest, step);
        ++count;
      }
  if (count > 0) difference.mean /= count;
  return difference;
}
}  // namespace tapestry::shell

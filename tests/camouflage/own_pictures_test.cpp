#include <tapestry/io/image_file.hpp>
#include <tapestry/io/mesh_writers.hpp>
#include <tapestry/io/obj_file.hpp>
#include <tapestry/raster/mesh_pictures.hpp>
#include <tapestry/raster/painted.hpp>

#include "../support/catch.hpp"
#include "../support/random_array.hpp"
#include "../support/temporary_folder.hpp"
#include "../support/tiny_scene.hpp"

using namespace tapestry;

namespace {
Array<std::uint8_t, 3> some_picture(std::size_t height, std::size_t width, std::size_t seed) {
  Array<std::uint8_t, 3> picture(Extents<3>{height, width, 3});
  Random random(seed);
  for (auto& value : picture.storage()) value = static_cast<std::uint8_t>(random.index(256));
  return picture;
}

/// The tiny car with pictures on roof and floor, which are not painted.
raster::PaintedMesh pictured_car(raster::TextureKind kind, raster::TextureFilter filter) {
  auto car = test::tiny_car(12, kind);
  car.layout.filter = filter;
  car.space = image::ColourSpace::linear;
  for (const std::size_t face : {8U, 9U}) car.painted[face] = 0;
  auto pictures = std::make_shared<raster::MeshPictures>();
  std::vector<std::uint8_t> roof(12, 0), floor(12, 0);
  roof[8] = roof[9] = floor[10] = floor[11] = 1;
  raster::add_picture(*pictures, car.mesh, some_picture(9, 31, 1), roof, filter, car.space);
  raster::add_picture(*pictures, car.mesh, some_picture(1, 1, 2), floor, filter, car.space);
  car.pictures = pictures;
  car.pyramid = raster::pyramid_of(car);
  return car;
}

double dot(const auto& a, const auto& b) {
  return std::inner_product(a.data(), a.data() + a.size(), b.data(), 0.0);
}
}  // namespace

TEST_CASE("the gradient by a paint is that of the drawn picture, beside faces with pictures of their own",
          "[camouflage][own_pictures][gradient]") {
  const auto kind = GENERATE(raster::TextureKind::atlas, raster::TextureKind::cube);
  const auto filter = GENERATE(raster::TextureFilter::bilinear, raster::TextureFilter::anisotropic);
  const auto car = pictured_car(kind, filter);
  auto plain = car;
  plain.pictures = nullptr;
  const auto camera = geometry::orbit_camera(0.7, 0.5, 6, {0, 0, 0.7}, 1);
  const auto view = raster::texture_operator<double>(car, camera, 40, 40, raster::Light{}, 2);
  const auto without = raster::texture_operator<double>(plain, camera, 40, 40, raster::Light{}, 2);
  CHECK(view.weights == without.weights);
  CHECK(view.texels_of == without.texels_of);
  CHECK(view.constant != without.constant);  // the roof is in view

  const auto texels = test::random_array<double>({view.texel_count, 3}, 3);
  const auto direction = test::random_array<double>({view.texel_count, 3}, 4, -1, 1);
  const auto weights = test::random_array<double>({40, 40, 3}, 5, -1, 1);
  const auto drawn = [&](double step) {
    auto moved = texels;
    for (std::size_t i = 0; i < moved.size(); ++i) moved.data()[i] += step * direction.data()[i];
    return dot(weights, raster::render_textured(car, camera, 40, 40, raster::Light{}, moved, 2).colour);
  };
  auto gradient = tapestry::zeros<double, 2>(texels.shape());
  raster::render_adjoint(view, weights, gradient);
  // Affine in the texels: the difference is rounding alone, with that of float lookups when filtered.
  const double tolerance = filter == raster::TextureFilter::bilinear ? 1e-10 : 1e-3;
  CHECK(std::abs(dot(gradient, direction) - (drawn(0.5) - drawn(-0.5))) < tolerance);
  CHECK(std::abs(dot(weights, raster::render(view, texels)) - drawn(0)) < tolerance);
}

TEST_CASE("own colours of painted faces are the means of their pictures over each texel",
          "[camouflage][own_pictures]") {
  auto car = test::tiny_car(12);  // 12 x 24 texels over u in 0 to 2, so that a picture shows twice
  car.space = GENERATE(image::ColourSpace::encoded, image::ColourSpace::linear);
  const std::size_t finer = GENERATE(1U, 3U);
  const auto picture = some_picture(12 * finer, 12 * finer, 6);
  auto pictures = std::make_shared<raster::MeshPictures>();
  raster::add_picture(*pictures, car.mesh, picture, car.painted, raster::TextureFilter::anisotropic,
                      car.space);
  car.pictures = pictures;
  const auto colours = camouflage::own_colours<float>(car);
  const bool is_linear = car.space == image::ColourSpace::linear;
  for (std::size_t row = 0; row < 12; ++row)
    for (std::size_t column = 0; column < 20; ++column)  // the painted sides
      for (std::size_t c = 0; c < 3; ++c) {
        float mean = 0;
        for (std::size_t y = 0; y < finer; ++y)
          for (std::size_t x = 0; x < finer; ++x) {
            const float value =
                static_cast<float>(picture(finer * row + y, finer * (column % 12) + x, c)) / 255.0F;
            mean += (is_linear ? image::linearised(value) : value) / static_cast<float>(finer * finer);
          }
        CHECK(std::abs(colours(24 * row + column, c) - (is_linear ? image::encoded(mean) : mean)) < 2e-5F);
      }
}

TEST_CASE("own colours of cubes, vertices and one colour are those of a plain picture",
          "[camouflage][own_pictures]") {
  auto car = test::tiny_car(
      12, GENERATE(raster::TextureKind::cube, raster::TextureKind::vertex, raster::TextureKind::solid));
  car.painted.assign(12, 1);
  Array<std::uint8_t, 3> picture(Extents<3>{8, 16, 3}, std::uint8_t(51));
  auto pictures = std::make_shared<raster::MeshPictures>();
  raster::add_picture(*pictures, car.mesh, picture, car.painted, raster::TextureFilter::bilinear, car.space);
  car.pictures = pictures;
  const auto colours = camouflage::own_colours<float>(car);
  REQUIRE(colours.shape(0) == car.layout.texel_count(car.mesh));
  for (const float value : colours.storage()) CHECK(std::abs(value - 0.2F) < 1e-6F);
}

TEST_CASE("a painted car is written with the pictures of its other faces", "[camouflage][own_pictures][io]") {
  const auto kind = GENERATE(raster::TextureKind::atlas, raster::TextureKind::cube);
  const test::TemporaryFolder folder;
  auto car = pictured_car(kind, raster::TextureFilter::bilinear);
  car.mesh.materials.push_back({"roof", {1, 0, 0}, folder.path("roof.png")});
  car.mesh.materials[1].texture = folder.path("floor.png");
  car.mesh.face_materials[8] = car.mesh.face_materials[9] = 2;
  io::write_image(folder.path("roof.png"), some_picture(9, 31, 1));
  io::write_image(folder.path("floor.png"), some_picture(1, 1, 2));
  const auto colours = tapestry::filled<float, 2>({car.layout.texel_count(car.mesh), 3}, 0.4F);
  const auto atlas = camouflage::atlas_of<float>(car, colours);
  io::write_painted_obj(folder.path("painted.obj"), car, atlas);

  auto written = raster::painted(io::read_obj(folder.path("painted.obj")).mesh, {.material = "paint"});
  CHECK(written.painted == car.painted);
  written.layout = car.layout;  // a cube's pictures are looked up for each sample, others for each pixel
  if (kind == raster::TextureKind::atlas) written.layout.kind = raster::TextureKind::solid;
  written.pyramid = nullptr;
  written.space = car.space;
  auto pictures = std::make_shared<raster::MeshPictures>();
  for (std::size_t material = 0; material < written.mesh.materials.size(); ++material) {
    const auto& [name, colour, texture] = written.mesh.materials[material];
    if (texture.empty() || name == "paint") continue;
    std::vector<std::uint8_t> faces;
    for (const auto index : written.mesh.face_materials)
      faces.push_back(index == static_cast<std::int32_t>(material) ? 1 : 0);
    raster::add_picture(*pictures, written.mesh, io::read_image(texture), faces,
                        raster::TextureFilter::bilinear, car.space);
  }
  CHECK(pictures->pictures.size() == 2);
  written.pictures = pictures;
  for (const double elevation : {0.5, -0.5}) {
    const auto camera = geometry::orbit_camera(0.7, elevation, 6, {0, 0, 0.7}, 1);
    const auto own = raster::texture_operator<float>(car, camera, 48, 48, raster::Light{}, 2);
    const auto other = raster::texture_operator<float>(written, camera, 48, 48, raster::Light{}, 2);
    const auto picture = raster::render(own, image::in_space(car.space, colours));
    const auto paint = tapestry::filled<float, 2>({written.layout.texel_count(written.mesh), 3}, 0.4F);
    const auto back = raster::render(other, image::in_space(car.space, paint));
    for (std::size_t i = 0; i < picture.size(); ++i)
      CHECK(std::abs(picture.data()[i] - back.data()[i]) < 2e-6F);  // uvs are written to the bit
  }
}

#include <tapestry/raster/mesh_pictures.hpp>

#include <tapestry/raster/detail/render_textured.hpp>
#include <tapestry/raster/detail/surface.hpp>
#include <tapestry/raster/texture_operator.hpp>

#include "../support/catch.hpp"

using namespace tapestry;

namespace {
/// A wall of three squares side by side, y to the right and z up, seen along −x; each has uv from 0 to 1.
geometry::Mesh wall_of_three() {
  geometry::Mesh mesh;
  mesh.uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
  for (int square = 0; square < 3; ++square) {
    const double left = square;
    const auto first = static_cast<std::int32_t>(mesh.positions.size());
    mesh.positions.insert(mesh.positions.end(),
                          {{0, left, 0}, {0, left + 1, 0}, {0, left + 1, 1}, {0, left, 1}});
    mesh.faces.push_back({first, first + 1, first + 2});
    mesh.faces.push_back({first, first + 2, first + 3});
    mesh.face_uvs.push_back({0, 1, 2});
    mesh.face_uvs.push_back({0, 2, 3});
  }
  mesh.face_materials = {0, 0, 1, 1, 2, 2};
  mesh.materials = {{"first", {0, 0, 1}}, {"second", {0, 1, 0}}, {"plain", {0.25F, 0.5F, 0.75F}}};
  return mesh;
}

/// From 3 m before the wall's middle; 48 x 16 pixels show the wall and nothing else.
geometry::Camera before_wall() {
  auto camera = geometry::orbit_camera(0, 0, 3, {0, 1.5, 0.5}, 1);
  camera.tan_half_fov_x = 0.5;
  camera.tan_half_fov_y = 0.5 / 3;
  return camera;
}

/// Red rises to the right and green upwards over the centres of 4 x 4 pixels; blue is b.
Array<std::uint8_t, 3> ramps(std::uint8_t b) {
  Array<std::uint8_t, 3> picture(Extents<3>{4, 4, 3});
  for (std::size_t row = 0; row < 4; ++row)
    for (std::size_t column = 0; column < 4; ++column) {
      picture(row, column, 0) = static_cast<std::uint8_t>(60 * column);
      picture(row, column, 1) = static_cast<std::uint8_t>(60 * (3 - row));
      picture(row, column, 2) = b;
    }
  return picture;
}

/// The ramp's value at u or v in 0.125 to 0.875, where bilinear lookups lie on it.
double ramp_at(double u) { return (u * 4 - 0.5) * 60 / 255; }

raster::PaintedMesh pictured(raster::TextureFilter filter, image::ColourSpace space) {
  raster::PaintedMesh body{wall_of_three(), {0, 0, 0, 0, 0, 0}, {}, space};
  body.layout.kind = raster::TextureKind::solid;
  auto pictures = std::make_shared<raster::MeshPictures>();
  raster::add_picture(*pictures, body.mesh, ramps(10), {1, 1, 0, 0, 0, 0}, filter, space);
  raster::add_picture(*pictures, body.mesh, ramps(200), {0, 0, 1, 1, 0, 0}, filter, space);
  body.pictures = pictures;
  return body;
}
}  // namespace

TEST_CASE("faces that are not painted show the pictures of the mesh, each its own",
          "[raster][mesh_pictures]") {
  const auto filter = GENERATE(raster::TextureFilter::bilinear, raster::TextureFilter::anisotropic);
  const auto body = pictured(filter, image::ColourSpace::encoded);
  const auto texels = tapestry::zeros<float, 2>({1, 3});
  const auto view = raster::texture_operator<float>(body, before_wall(), 16, 48, raster::Unlit{}, 2);
  const auto picture = raster::render(view, texels);
  const auto drawn = raster::render_textured(body, before_wall(), 16, 48, raster::Unlit{}, texels, 2).colour;
  for (std::size_t i = 0; i < drawn.size(); ++i) CHECK(std::abs(drawn.data()[i] - picture.data()[i]) < 1e-6F);
  for (std::size_t row = 3; row < 13; ++row)
    for (std::size_t column = 0; column < 48; ++column) {
      const std::size_t square = column / 16;
      const double u = (static_cast<double>(column % 16) + 0.5) / 16;
      const double v = 1 - (static_cast<double>(row) + 0.5) / 16;
      if (u < 0.19 || u > 0.81) continue;
      const std::array<double, 3> expected =
          square == 2 ? std::array<double, 3>{0.25, 0.5, 0.75}
                      : std::array<double, 3>{ramp_at(u), ramp_at(v), (square == 0 ? 10 : 200) / 255.0};
      for (std::size_t c = 0; c < 3; ++c)
        CHECK(std::abs(static_cast<double>(picture(row, column, c)) - expected[c]) < 1e-5);
    }
}

TEST_CASE("pictures are looked up in light where the body is drawn so", "[raster][mesh_pictures]") {
  const auto body = pictured(raster::TextureFilter::bilinear, image::ColourSpace::linear);
  const auto view = raster::texture_operator<float>(body, before_wall(), 16, 48, raster::Unlit{}, 2);
  const auto picture = raster::render(view, tapestry::zeros<float, 2>({1, 3}));
  CHECK(std::abs(picture(8, 24, 2) - image::linearised(200 / 255.0F)) < 1e-6F);
  CHECK(std::abs(picture(8, 40, 0) - image::linearised(0.25F)) < 1e-6F);
}

TEST_CASE("a paint covers the picture of its faces", "[raster][mesh_pictures]") {
  auto body = pictured(raster::TextureFilter::bilinear, image::ColourSpace::encoded);
  body.painted = {1, 1, 0, 0, 0, 0};
  const auto view = raster::texture_operator<float>(body, before_wall(), 16, 48, raster::Unlit{}, 2);
  const auto picture = raster::render(view, tapestry::filled<float, 2>({1, 3}, 0.5F));
  CHECK(picture(8, 8, 2) == 0.5F);
  CHECK(std::abs(picture(8, 24, 2) - 200 / 255.0F) < 1e-6F);
}

TEST_CASE("the slope of a picture on a face agrees with differences", "[raster][mesh_pictures][gradient]") {
  const auto body = pictured(raster::TextureFilter::bilinear, image::ColourSpace::encoded);
  const auto texels = tapestry::zeros<double, 2>({1, 3});
  const auto colour = raster::surface_colour(
      "test", raster::Surface<double, raster::Unlit>{body, texels, raster::Unlit{}}, before_wall());
  const std::array<double, 3> b{0.31, 0.27, 0.42};
  const double h = 1e-6;
  for (std::int32_t face = 0; face < 6; ++face)
    for (std::size_t k = 0; k < 3; ++k) {
      auto up = b, down = b;
      up[k] += h;
      down[k] -= h;
      for (std::size_t c = 0; c < 3; ++c)
        CHECK(std::abs(colour.slope(face, b)[c][k] -
                       (colour.at(face, up)[c] - colour.at(face, down)[c]) / (2 * h)) <
              1e-8);  // the lookup is bilinear: only rounding, 1e-16 / h
    }
  const auto filtered = pictured(raster::TextureFilter::anisotropic, image::ColourSpace::encoded);
  CHECK_THROWS_AS(
      raster::surface_colour(
          "test", raster::Surface<double, raster::Unlit>{filtered, texels, raster::Unlit{}}, before_wall()),
      DomainError);
}

TEST_CASE("a picture's mean over a square of texels is the mean of these", "[raster][mesh_pictures]") {
  const auto body = pictured(raster::TextureFilter::bilinear, image::ColourSpace::encoded);
  const auto& picture = *body.pictures->at(0);
  const auto mean = raster::mean_colour(picture, body.space, {0.25, 0.25}, {{{0.5, 0}, {0, 0.5}}});
  CHECK(std::abs(mean[0] - 30 / 255.0F) < 1e-6F);  // of 0, 60, 0, 60
  CHECK(std::abs(mean[1] - 30 / 255.0F) < 1e-6F);
  CHECK(std::abs(mean[2] - 10 / 255.0F) < 1e-6F);
}

TEST_CASE("pictures that do not fit the mesh are refused", "[raster][mesh_pictures][error]") {
  auto body = pictured(raster::TextureFilter::bilinear, image::ColourSpace::encoded);
  raster::MeshPictures pictures;
  const auto add = [&](const std::vector<std::uint8_t>& faces) {
    raster::add_picture(pictures, body.mesh, ramps(0), faces, raster::TextureFilter::bilinear, body.space);
  };
  CHECK_THROWS_AS(add({1, 1}), ShapeError);
  body.mesh.face_uvs[1] = {-1, -1, -1};
  CHECK_THROWS_AS(add({0, 1, 0, 0, 0, 0}), Error);
  body.mesh.faces.pop_back();
  body.painted.pop_back();
  CHECK_THROWS_AS(raster::texture_operator<float>(body, before_wall(), 16, 48, raster::Unlit{}, 2),
                  ShapeError);
}

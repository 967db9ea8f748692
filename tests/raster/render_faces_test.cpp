#include <algorithm>
#include <cmath>
#include <tapestry/raster/render_faces.hpp>
#include <tapestry/raster/texture_operator.hpp>

#include "../support/catch.hpp"
#include "../support/simple_mesh.hpp"

namespace raster = tapestry::raster;

TEST_CASE("render_faces equals the unpainted part of a texture operator", "[raster][render_faces]") {
  auto mesh = tapestry::test::random_triangles(80, 1);
  tapestry::Random random(2);
  std::vector<std::array<float, 3>> colours(mesh.faces.size());
  for (std::size_t face = 0; face < colours.size(); ++face) {
    for (float& channel : colours[face]) channel = static_cast<float>(random.uniform());
    mesh.materials.push_back({"", colours[face]});
    mesh.face_materials[face] = static_cast<std::int32_t>(face);
  }
  const raster::Light light{0.4, 0.5, {1, -1, -1}, {1, 0.9, 0.7}};
  const tapestry::geometry::Camera camera;
  const auto picture = raster::render_faces(mesh, colours, camera, 31, 22, light, 4);
  const auto reference = raster::texture_operator<double>(
      {mesh, std::vector<std::uint8_t>(80, 0), {raster::TextureKind::cube, 0, 0, 1, 1}}, camera, 31, 22,
      light, 4);
  double error = 0;
  for (std::size_t i = 0; i < picture.colour.size(); ++i) {
    error = std::max(error,
                     std::abs(static_cast<double>(picture.colour.data()[i]) - reference.constant.data()[i]));
  }
  CHECK(error <= 16 * 1.2e-7);  // 16 samples are added in float
  bool is_first_sample = true;
  for (std::size_t pixel = 0; pixel < 31 * 22; ++pixel) {
    CHECK(static_cast<double>(picture.coverage.data()[pixel]) == reference.coverage.data()[pixel]);
    const std::size_t sample = pixel / 22 * 4 * 88 + pixel % 22 * 4;
    is_first_sample = is_first_sample && picture.face[pixel] == picture.visibility.face[sample];
  }
  CHECK(is_first_sample);
  CHECK(reference.pixels.empty());
}

TEST_CASE("render_faces wants a colour for every face", "[raster][render_faces]") {
  const auto mesh = tapestry::test::random_triangles(2, 1);
  CHECK_THROWS_WITH(raster::render_faces(mesh, {}, {}, 8, 8, {}),
                    "render_faces: face_colours is [0], expected [2], one entry a face");
}

#include <tapestry/raster/detail/render_textured.hpp>
#include <tapestry/raster/texture_operator.hpp>

#include "../support/random_array.hpp"
#include "../support/relative_distance.hpp"
#include "../support/simple_mesh.hpp"

namespace raster = tapestry::raster;

TEST_CASE("render_textured equals the picture of a texture operator", "[raster][render_textured]") {
  const auto mesh = tapestry::test::random_triangles(120, 1, 0.5, 0, 2);
  std::vector<std::uint8_t> painted(120, 1);
  for (std::size_t face = 0; face < painted.size(); face += 3) painted[face] = 0;
  const raster::Light light{0.4, 0.5, {1, -1, -1}, {1, 0.9, 0.7}};
  const tapestry::geometry::Camera camera;
  for (const raster::TextureLayout& layout : {raster::TextureLayout{raster::TextureKind::atlas, 8, 16, 2, 0},
                                              raster::TextureLayout{raster::TextureKind::cube, 0, 0, 1, 3}}) {
    const auto texels = tapestry::test::random_array<double>({layout.texel_count(mesh), 3}, 2);
    for (const std::size_t samples : std::vector<std::size_t>{1, 4}) {
      const auto picture =
          raster::render_textured({mesh, painted, layout}, camera, 37, 70, light, texels, samples);
      const auto linear =
          raster::texture_operator<double>({mesh, painted, layout}, camera, 37, 70, light, samples);
      const auto expected = raster::render(linear, texels);
      CHECK(tapestry::test::largest_difference(picture.colour, expected) <= 1e-12);
      CHECK(picture.coverage == linear.coverage);
    }
  }
}

TEST_CASE("render_textured refuses texels that do not fit", "[raster][render_textured]") {
  const auto mesh = tapestry::test::random_triangles(2, 1);
  const tapestry::Array<float, 2> texels = tapestry::zeros<float, 2>({5, 3});
  CHECK_THROWS_WITH(
      raster::render_textured({mesh, {1, 1}, {raster::TextureKind::cube, 0, 0, 1, 1}}, {}, 8, 8, {}, texels),
      "render_textured: texels is [5, 3], expected [2, 3]");
}

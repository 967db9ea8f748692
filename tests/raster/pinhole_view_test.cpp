#include <tapestry/raster/texture_operator.hpp>

#include "../support/catch.hpp"
#include "../support/paint.hpp"
#include "../support/random_array.hpp"
#include "../support/simple_mesh.hpp"

using namespace tapestry;

TEST_CASE("a principal point beside the picture's centre shows a window of the larger picture",
          "[raster][camera]") {
  // Faces of one texel each, so that a sample's colour depends only on its face and the light.
  const auto mesh = test::random_triangles(150, 1, 0.6);
  const auto painted = test::every_face(mesh);
  const raster::TextureLayout cube{raster::TextureKind::cube, 0, 0, 1, 1};
  const auto texels = test::random_array<double>({mesh.faces.size(), 3}, 2);
  const auto draw = [&](const geometry::Camera& camera, std::size_t height, std::size_t width) {
    return raster::render(
        raster::texture_operator<double>({mesh, painted, cube}, camera, height, width, test::warm, 2),
        texels);
  };
  const auto whole = draw(geometry::Camera{}, 64, 64);
  // Rows 8 … 39 and columns 24 … 63 of it: the same focal length, the centre at column 32 − 24, row 32 − 8.
  const geometry::Camera window_camera =
      geometry::pinhole_camera({32, 32, 8, 24, 40, 32}, geometry::Camera{}.rotation, {0, 0, 0});
  const auto window = draw(window_camera, 32, 40);
  std::size_t differing = 0;
  for (std::size_t i = 0; i < 32; ++i)
    for (std::size_t j = 0; j < 40; ++j)
      for (std::size_t c = 0; c < 3; ++c)
        differing += std::abs(window(i, j, c) - whole(i + 8, j + 24, c)) > 1e-9 ? 1 : 0;
  CHECK(differing <= 3 * 2);  // corners half way between two steps of 1/256 may be snapped either way
}

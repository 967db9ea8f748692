#include <tapestry/raster/bake.hpp>
#include <tapestry/raster/texture_operator.hpp>

#include "../support/random_array.hpp"
#include "../support/relative_distance.hpp"

using namespace tapestry;
using geometry::Camera, geometry::Mesh, raster::TextureKind, raster::TextureLayout;

namespace {
/// A square of two faces over the whole picture, its uv span the picture, and a third
/// face beside it without uv.
Mesh screen() {
  Mesh mesh;
  mesh.positions = {{-2, -2, 2}, {2, -2, 2}, {2, 2, 2}, {-2, 2, 2}, {9, 9, 2}};
  mesh.uvs = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
  mesh.faces = {{0, 1, 2}, {0, 2, 3}, {1, 4, 2}};
  mesh.face_uvs = {{0, 1, 2}, {0, 2, 3}, {-1, -1, -1}};
  mesh.face_materials = {-1, -1, -1};
  return mesh;
}

const std::vector<std::uint8_t> painted{1, 1, 0};
const TextureLayout cube{TextureKind::cube, 0, 0, 1, 6};

TextureLayout atlas(std::size_t size) { return {TextureKind::atlas, size, size, 1, 0}; }

/// 0.2 + 0.5·u, 0.1 + 0.6·v and their mean at the texels' centres.
Array<double, 2> ramp(std::size_t size) {
  Array<double, 2> texels(Extents<2>{size * size, 3});
  for (std::size_t i = 0; i < size * size; ++i) {
    texels(i, 0) = 0.2 + 0.5 * (static_cast<double>(i % size) + 0.5) / static_cast<double>(size);
    texels(i, 1) = 0.7 - 0.6 * (static_cast<double>(i / size) + 0.5) / static_cast<double>(size);
    texels(i, 2) = (texels(i, 0) + texels(i, 1)) / 2;
  }
  return texels;
}

Array<double, 3> picture_of(const Mesh& mesh, const TextureLayout& layout, const Array<double, 2>& texels) {
  return raster::render(
      raster::texture_operator<double>({mesh, painted, layout}, Camera{}, 40, 40, raster::Unlit{}, 2),
      texels);
}
}  // namespace

TEST_CASE("cubes baked from an atlas hold its colours at their barycentric coordinates", "[raster][bake]") {
  const auto baked = raster::bake_cube({screen(), painted, atlas(64)}, ramp(64), cube);
  REQUIRE(baked.shape(0) == 3 * 216);
  // Texel (5, 0, 0) of face 0 is its corner 0, at uv (0, 1), within half a texel of the border.
  CHECK(baked(5 * 36, 0) == Approx(0.2 + 0.25 / 64));
  CHECK(baked(5 * 36, 1) == Approx(0.7 - 0.3 / 64));
  // Texel (1, 2, 1): b = (1/4, 1/2, 1/4), uv = (3/4, 3/4).
  CHECK(baked(36 + 12 + 1, 0) == Approx(0.2 + 0.5 * 0.75));
  CHECK(baked(36 + 12 + 1, 1) == Approx(0.1 + 0.6 * 0.75));
  // Texel (0, 0, 0), where the source divides by 0: the centroid, uv = (2/3, 2/3).
  CHECK(baked(0, 0) == Approx(0.2 + 0.5 * 2 / 3));
  for (std::size_t i = 2 * 216; i < 3 * 216; ++i) CHECK(baked(i, 1) == 0.5);  // not painted
}

TEST_CASE("an atlas baked into cubes and back keeps the picture", "[raster][bake]") {
  const Mesh mesh = screen();
  const auto texels = ramp(64);
  const auto before = picture_of(mesh, atlas(64), texels);
  const auto cubes = raster::bake_cube({mesh, painted, atlas(64)}, texels, cube);
  const auto back = raster::bake_atlas({mesh, painted, cube}, cubes, atlas(96));
  // A cube's taps beside the plane a + b + c = s − 1 are normalised, so even a ramp changes a little.
  CHECK(test::relative_distance(picture_of(mesh, cube, cubes), before) <= 0.02);
  CHECK(test::relative_distance(picture_of(mesh, atlas(96), back), picture_of(mesh, cube, cubes)) <= 0.005);
}

TEST_CASE("an atlas baked into itself comes back, vertex colours become a ramp", "[raster][bake]") {
  const Mesh mesh = screen();
  const auto texels = test::random_array<double>({24 * 24, 3}, 1);
  const auto same = raster::bake_atlas({mesh, painted, atlas(24)}, texels, atlas(24));
  CHECK(test::relative_distance(same, texels) <= 1e-12);
  const Array<double, 2> corners = {{0, 0, 0}, {1, 0, 0}, {1, 1, 0}, {0, 1, 0}, {0, 0, 1}};
  const auto baked =
      raster::bake_atlas({mesh, painted, {TextureKind::vertex, 0, 0, 1, 0}}, corners, atlas(24));
  double error = 0;
  for (std::size_t i = 0; i < 24 * 24; ++i) {
    error = std::max(error, std::abs(baked(i, 0) - (static_cast<double>(i % 24) + 0.5) / 24));
    error = std::max(error, std::abs(baked(i, 1) - (static_cast<double>(i / 24) + 0.5) / 24));
  }
  CHECK(error <= 1e-12);
}

TEST_CASE("beside a chart, and far from it, its rim's colour is kept", "[raster][bake]") {
  Mesh mesh = screen();
  for (auto& uv : mesh.uvs) uv = {0.25 + uv[0] / 2, 0.25 + uv[1] / 2};  // the middle of the atlas
  const Array<double, 2> red = {{1, 0, 0}};
  const auto baked = raster::bake_atlas({mesh, painted, {TextureKind::solid, 0, 0, 1, 0}}, red, atlas(16));
  CHECK(baked(8 * 16 + 8, 0) == 1);
  CHECK(baked(8 * 16 + 3, 0) == 1);  // half a texel to the left of the chart
  CHECK(baked(8 * 16 + 2, 0) == Approx(1));
  CHECK(baked(0, 0) == Approx(1));
  CHECK(baked(0, 1) == 0);
  const auto bare = raster::bake_atlas({mesh, {0, 0, 0}, {TextureKind::solid, 0, 0, 1, 0}}, red, atlas(16));
  CHECK(baked.shape() == bare.shape());
  for (std::size_t i = 0; i < bare.size(); ++i) REQUIRE(bare.data()[i] == 0.5);
}

TEST_CASE("baking refuses what does not fit", "[raster][bake][bad_input]") {
  const Mesh mesh = screen();
  CHECK_THROWS_AS(raster::bake_cube({mesh, painted, atlas(8)}, ramp(7), cube), ShapeError);
  CHECK_THROWS_AS(raster::bake_cube({mesh, painted, atlas(8)}, ramp(8), atlas(8)), DomainError);
  CHECK_THROWS_AS(raster::bake_atlas({mesh, painted, atlas(8)}, ramp(8), cube), DomainError);
  CHECK_THROWS_AS(raster::bake_atlas({mesh, {1, 1}, atlas(8)}, ramp(8), atlas(8)), ShapeError);
  CHECK_THROWS_AS(raster::bake_atlas({mesh, {1, 1, 1}, atlas(8)}, ramp(8), atlas(8)),
                  Error);  // no uv
}

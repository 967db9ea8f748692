#include <cmath>
#include <tapestry/image/colour_space.hpp>
#include <tapestry/raster/texture_operator.hpp>

#include "../support/catch.hpp"
#include "../support/random_array.hpp"
#include "../support/relative_distance.hpp"
#include "../support/simple_mesh.hpp"

namespace raster = tapestry::raster;
using raster::TextureFilter;
using raster::TextureKind;
using tapestry::Array;
using tapestry::geometry::Camera;
using tapestry::geometry::Mesh;
using tapestry::geometry::Vector3;
using tapestry::test::random_array;

namespace {

raster::TextureLayout layout_of(std::size_t height, std::size_t width,
                                TextureFilter filter = TextureFilter::trilinear) {
  return {TextureKind::atlas, height, width, 1, 0, filter};
}

/// A floor that runs from under the camera to far ahead, with the atlas repeated every two units.
Mesh floor_to_the_horizon() {
  Mesh mesh =
      tapestry::test::triangle_soup({{Vector3{-60, 1, 0.5}, Vector3{60, 1, 0.5}, Vector3{0, 1, 120}}});
  for (std::size_t k = 0; k < 3; ++k) mesh.uvs[k] = {mesh.positions[k][0] / 2, mesh.positions[k][2] / 2};
  return mesh;
}

}  // namespace

TEST_CASE("a pyramid's texels are means of the areas that they cover", "[raster][mip_pyramid]") {
  const auto layout = layout_of(2, 5);
  const auto levels = raster::mip_levels(layout);
  REQUIRE(levels.size() == 3);
  CHECK(levels[1].height == 1);
  CHECK(levels[1].width == 2);
  CHECK(levels[2].first_texel == 12);
  auto texels = tapestry::zeros<double, 2>({10, 3});
  for (std::size_t i = 0; i < 10; ++i) texels(i, 1) = static_cast<double>(i);
  const auto pyramid = raster::mip_pyramid(layout, texels);
  // Columns 0, 1 and half of 2, of both rows: (0 + 1 + 2/2 + 5 + 6 + 7/2) / 5.
  CHECK(pyramid(10, 1) == Approx(16.5 / 5));
  CHECK(pyramid(11, 1) == Approx(28.5 / 5));
  CHECK(pyramid(12, 1) == Approx(4.5));
  CHECK(pyramid(12, 0) == 0);
}

TEST_CASE("the top of a pyramid is the mean, for any size", "[raster][mip_pyramid]") {
  for (const auto& [height, width] : {std::pair<std::size_t, std::size_t>{1, 1}, {7, 13}, {64, 3}, {1, 31}}) {
    const auto layout = layout_of(height, width);
    const auto texels = random_array<double>({height * width, 3}, 1);
    const auto pyramid = raster::mip_pyramid(layout, texels);
    double mean = 0;
    for (std::size_t i = 0; i < height * width; ++i) mean += texels(i, 2);
    mean /= static_cast<double>(height * width);
    CHECK(std::abs(pyramid(pyramid.shape(0) - 1, 2) - mean) <= 1e-12);
  }
}

TEST_CASE("mip_pyramid_adjoint is the transpose of mip_pyramid", "[raster][mip_pyramid][gradient]") {
  const auto layout = layout_of(9, 14);
  const auto x = random_array<double>({126, 3}, 2, -1);
  const auto forward = raster::mip_pyramid(layout, x);
  const auto y = random_array<double>({forward.shape(0), 3}, 3, -1);
  auto gradient = tapestry::zeros<double, 2>({126, 3});
  raster::mip_pyramid_adjoint(layout, y, gradient);
  raster::mip_pyramid_adjoint(layout, y, gradient);  // adds
  double left = 0, right = 0;
  for (std::size_t i = 0; i < y.size(); ++i) left += y.data()[i] * forward.data()[i];
  for (std::size_t i = 0; i < x.size(); ++i) right += gradient.data()[i] * x.data()[i] / 2;
  CHECK(std::abs(left - right) <= 1e-12);
  CHECK_THROWS_AS(raster::mip_pyramid(layout, y), tapestry::ShapeError);
  CHECK_THROWS_AS(raster::mip_pyramid_adjoint(layout, x, gradient), tapestry::ShapeError);
}

TEST_CASE("barycentric_slope agrees with central differences", "[raster][footprint]") {
  const Mesh mesh = tapestry::test::random_triangles(20, 4);
  Camera camera;
  camera.tan_half_fov_x = 1.25;
  double error = 0;
  for (std::int32_t face = 0; face < 20; ++face) {
    std::array<Vector3, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) corners[k] = mesh.positions[static_cast<std::size_t>(3 * face) + k];
    const Vector3 centre = tapestry::geometry::scale(
        tapestry::geometry::add(tapestry::geometry::add(corners[0], corners[1]), corners[2]), 1.0 / 3);
    const auto slope = raster::barycentric_slope(corners, {1.0 / 3, 1.0 / 3, 1.0 / 3}, camera, 40, 60);
    const auto at = [&](double column, double row) {
      const Vector3 ray{centre[0] / centre[2] + column * 2 * camera.tan_half_fov_x / 60,
                        centre[1] / centre[2] + row * 2 * camera.tan_half_fov_y / 40, 1};
      std::array<double, 3> b{};
      double sum = 0;
      for (std::size_t k = 0; k < 3; ++k) {
        b[k] = tapestry::geometry::dot(ray,
                                       tapestry::geometry::cross(corners[(k + 1) % 3], corners[(k + 2) % 3]));
        sum += b[k];
      }
      for (double& value : b) value /= sum;
      return b;
    };
    const double h = 1e-6;
    for (std::size_t k = 0; k < 3; ++k) {
      error = std::max(error, std::abs(slope.per_column[k] - (at(h, 0)[k] - at(-h, 0)[k]) / (2 * h)) /
                                  (1 + std::abs(slope.per_column[k])));
      error = std::max(error, std::abs(slope.per_row[k] - (at(0, h)[k] - at(0, -h)[k]) / (2 * h)) /
                                  (1 + std::abs(slope.per_row[k])));
    }
  }
  CHECK(error <= 1e-6);
}

TEST_CASE("trilinear comes nearer to the area average than bilinear", "[raster][mip_pyramid]") {
  const Mesh mesh = floor_to_the_horizon();
  const auto texels = random_array<double>({64 * 64, 3}, 5);
  const auto fine = layout_of(64, 64, TextureFilter::bilinear);
  const auto reference = raster::render(
      raster::texture_operator<double>({mesh, {1}, fine}, Camera{}, 480, 640, raster::Unlit{}, 8), texels);
  Array<double, 3> mean = tapestry::zeros<double, 3>({60, 80, 3});  // of 64 × 64 samples a pixel
  for (std::size_t i = 0; i < 480; ++i)
    for (std::size_t j = 0; j < 640; ++j)
      for (std::size_t c = 0; c < 3; ++c) mean(i / 8, j / 8, c) += reference(i, j, c) / 64;
  const auto error_of = [&](TextureFilter filter, std::size_t samples) {
    const auto layout = layout_of(64, 64, filter);
    const auto picture =
        raster::texture_operator<double>({mesh, {1}, layout}, Camera{}, 60, 80, raster::Unlit{}, samples);
    return tapestry::test::relative_distance(
        raster::render(picture,
                       filter == TextureFilter::trilinear ? raster::mip_pyramid(layout, texels) : texels),
        mean);
  };
  // Random texels, far smaller than pixels: one of them is off by their spread, 0.29 of 0.5.
  CHECK(error_of(TextureFilter::bilinear, 4) >= 0.2);
  CHECK(error_of(TextureFilter::trilinear, 4) <= 0.5 * error_of(TextureFilter::bilinear, 4));
}

TEST_CASE("a pattern finer than pixels is a camera's grey in light and too dark by numbers",
          "[raster][image]") {
  // A wall of 512 x 512 black and white texels, 16 of them across a pixel.
  Mesh wall = tapestry::test::triangle_soup({{Vector3{-4, -4, 2}, Vector3{12, -4, 2}, Vector3{-4, 12, 2}}});
  for (std::size_t k = 0; k < 3; ++k)
    wall.uvs[k] = {(wall.positions[k][0] + 4) / 8, (wall.positions[k][1] + 4) / 8};
  auto texels = tapestry::zeros<double, 2>({512 * 512, 3});
  for (std::size_t i = 0; i < 512 * 512; ++i)
    for (std::size_t c = 0; c < 3; ++c) texels(i, c) = static_cast<double>((i / 512 + i % 512) % 2);
  const auto picture_of = [&](const raster::TextureLayout& layout, std::size_t side, std::size_t samples,
                              const Array<double, 2>& of) {
    return raster::render(
        raster::texture_operator<double>({wall, {1}, layout}, Camera{}, side, side, raster::Unlit{}, samples),
        of);
  };
  const auto seen = picture_of(layout_of(512, 512, TextureFilter::bilinear), 16 * 64, 1,
                               tapestry::image::linearised(texels));
  auto light = tapestry::zeros<double, 3>({16, 16, 3});  // of 64 × 64 samples a pixel
  for (std::size_t i = 0; i < seen.shape(0); ++i)
    for (std::size_t j = 0; j < seen.shape(1); ++j)
      for (std::size_t c = 0; c < 3; ++c) light(i / 64, j / 64, c) += seen(i, j, c) / (64 * 64);
  const auto camera = tapestry::image::encoded(light);
  const auto layout = layout_of(512, 512);
  const auto pyramid_of = [&](const Array<double, 2>& of) { return raster::mip_pyramid(layout, of); };
  const auto linear =
      tapestry::image::encoded(picture_of(layout, 16, 4, pyramid_of(tapestry::image::linearised(texels))));
  const auto encoded = picture_of(layout, 16, 4, pyramid_of(texels));
  for (std::size_t i = 0; i < camera.size(); ++i) {
    REQUIRE(camera.data()[i] == Approx(0.735).margin(0.01));
    REQUIRE(std::abs(linear.data()[i] - camera.data()[i]) <= 0.01);
    REQUIRE(std::abs(encoded.data()[i] - camera.data()[i]) >= 0.2);
  }
}

TEST_CASE("an atlas that is not minified is the same with both filters", "[raster][mip_pyramid]") {
  Mesh mesh = tapestry::test::triangle_soup({{Vector3{-2, -2, 2}, Vector3{6, -2, 2}, Vector3{-2, 6, 2}}});
  for (auto& uv : mesh.uvs) uv = {uv[0] / 4, uv[1] / 4};
  const auto texels = random_array<double>({16 * 16, 3}, 6);
  const auto at = [&](TextureFilter filter) {
    const auto layout = layout_of(16, 16, filter);
    const auto picture =
        raster::texture_operator<double>({mesh, {1}, layout}, Camera{}, 50, 50, raster::Unlit{}, 1);
    return raster::render(picture,
                          filter == TextureFilter::trilinear ? raster::mip_pyramid(layout, texels) : texels);
  };
  CHECK((at(TextureFilter::trilinear) == at(TextureFilter::bilinear)));
}

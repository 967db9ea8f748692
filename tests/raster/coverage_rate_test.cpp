#include <tapestry/raster/visibility.hpp>

#include "../support/catch.hpp"
#include "../support/simple_mesh.hpp"

namespace raster = tapestry::raster;
using tapestry::geometry::Camera, tapestry::geometry::Mesh, tapestry::geometry::Vector3,
    tapestry::test::triangle_soup;

namespace {
/// A right triangle at depth 1 whose short sides are so many pixels of a picture of 64.
Mesh triangle_of(double side_px) {
  const double side = side_px / 32;
  return triangle_soup({{Vector3{0, 0, 1}, Vector3{side, 0, 1}, Vector3{0, side, 1}}});
}
}  // namespace

TEST_CASE("the median edge is that of the picture", "[raster][coverage_rate]") {
  CHECK(raster::median_edge_px(triangle_of(3), Camera{}, 64, 64) == Approx(3).margin(1e-12));
  CHECK(raster::median_edge_px(triangle_of(3), Camera{}, 128, 128) == Approx(6).margin(1e-12));
}

TEST_CASE("the coverage rate makes the median edge four samples long", "[raster][coverage_rate]") {
  const auto rate_of = [](double side_px) {
    return raster::automatic_samples_per_axis(triangle_of(side_px), Camera{}, 64, 64);
  };
  CHECK(rate_of(5) == 1);
  CHECK(rate_of(3) == 2);
  CHECK(rate_of(1.5) == 4);
  CHECK(rate_of(0.6) == 8);
  CHECK(rate_of(0.01) == 8);
}

TEST_CASE("faces that are not in the picture do not count for the coverage rate", "[raster][coverage_rate]") {
  constexpr double nan = std::numeric_limits<double>::quiet_NaN();
  const Mesh mesh =
      triangle_soup({{Vector3{0, 0, -1}, Vector3{9, 0, 1}, Vector3{0, 9, 1}},        // behind the camera
                     {Vector3{nan, 0, 1}, Vector3{9, 0, 1}, Vector3{0, 9, 1}},       // not finite
                     {Vector3{5, 0, 1}, Vector3{5.001, 0, 1}, Vector3{5, 0.01, 1}},  // beside the picture
                     {Vector3{0, 0, 1}, Vector3{0.05, 0, 1}, Vector3{0, 0.05, 1}}});
  CHECK(raster::median_edge_px(mesh, Camera{}, 64, 64) == Approx(1.6).margin(1e-12));
  CHECK(raster::automatic_samples_per_axis(Mesh{}, Camera{}, 64, 64) == 1);
}

TEST_CASE("the coverage rate stays within what the rasteriser takes", "[raster][coverage_rate]") {
  CHECK(raster::automatic_samples_per_axis(triangle_of(0.001), Camera{}, 8192, 64) == 4);
  CHECK_THROWS_AS(raster::automatic_samples_per_axis(triangle_of(1), Camera{}, 0, 64), tapestry::DomainError);
  Mesh broken = triangle_of(1);
  broken.faces[0][1] = 7;
  CHECK_THROWS_AS(raster::automatic_samples_per_axis(broken, Camera{}, 64, 64), tapestry::Error);
}

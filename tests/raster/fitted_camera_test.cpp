#include <tapestry/raster/fitted_camera.hpp>

#include <tapestry/raster/silhouette.hpp>

#include "../support/catch.hpp"
#include "../support/simple_mesh.hpp"

using namespace tapestry;

namespace {
geometry::Camera of_a_wide_photograph() {
  return geometry::look_at({4, -3, 2}, {0.2, 0.1, -0.1}, {0, 0, 1}, 1.2, 0.7);
}
}  // namespace

TEST_CASE("a fitted camera sees points where the photograph's pixels go", "[raster][fitted_camera]") {
  const auto camera = of_a_wide_photograph();
  const auto kind =
      GENERATE(image::FitKind::letterbox, image::FitKind::letterbox_top_left, image::FitKind::stretch);
  for (const auto& [photo_height, photo_width] :
       {std::pair<std::size_t, std::size_t>(90, 160), {200, 75}, {64, 64}}) {
    INFO(photo_height << " x " << photo_width << ", " << image::name_of(kind));
    const auto fitted = raster::fitted_camera(camera, photo_height, photo_width, 96, 128, kind);
    const auto to_photo = image::picture_from_canvas(photo_height, photo_width, 96, 128, kind);
    for (const geometry::Vector3& point : {geometry::Vector3{0, 0, 0}, {0.5, 0.4, 0.1}, {-0.7, 0.3, 0.2}}) {
      const auto in_photo = geometry::view_from_world(camera, point),
                 on_canvas = geometry::view_from_world(fitted, point);
      CHECK(on_canvas[2] == in_photo[2]);
      const auto expected = geometry::picture_from_view(camera, in_photo, static_cast<double>(photo_height),
                                                        static_cast<double>(photo_width));
      const auto found = geometry::picture_from_view(fitted, on_canvas, 96, 128);
      CHECK(to_photo.y(found[0]) == Approx(expected[0]).epsilon(1e-12));
      CHECK(to_photo.x(found[1]) == Approx(expected[1]).epsilon(1e-12));
    }
  }
}

TEST_CASE("a fitted camera of a photograph with the canvas' aspect ratio is the same camera",
          "[raster][fitted_camera]") {
  const auto camera = of_a_wide_photograph();
  const auto fitted = raster::fitted_camera(camera, 30, 40, 60, 80);
  CHECK(fitted.rotation == camera.rotation);
  CHECK(fitted.translation == camera.translation);
  CHECK(fitted.tan_half_fov_x == camera.tan_half_fov_x);
  CHECK(fitted.tan_half_fov_y == camera.tan_half_fov_y);
}

TEST_CASE("a silhouette by the fitted camera is that of the photograph, in its place",
          "[raster][fitted_camera]") {
  const auto camera = of_a_wide_photograph();
  const auto sphere = test::bumpy_sphere(2, 0.1, 1);
  // The photograph keeps its 64 rows on the canvas, so that both have the same samples.
  const auto photo = raster::silhouette<double>(sphere, camera, 40, 64, 4);
  const auto canvas =
      raster::silhouette<double>(sphere, raster::fitted_camera(camera, 40, 64, 64, 64), 64, 64, 4);
  double beside = 0, difference = 0, inside = 0;
  for (std::size_t y = 0; y < 64; ++y)
    for (std::size_t x = 0; x < 64; ++x) {
      if (y < 12 || y >= 52) continue;  // the camera sees on beside the photograph
      difference += std::abs(canvas(y, x) - photo(y - 12, x));
      inside += photo(y - 12, x);
    }
  for (std::size_t x = 0; x < 64; ++x) beside += canvas(0, x);
  CHECK(inside > 100);
  CHECK(beside == 0);
  CHECK(difference <= 1.0);  // of samples on edges of 1/256 sample
}

TEST_CASE("a fitted camera needs extents", "[raster][fitted_camera][bad_input]") {
  const auto camera = of_a_wide_photograph();
  CHECK_THROWS_AS(raster::fitted_camera(camera, 0, 10, 20, 20), DomainError);
  CHECK_THROWS_AS(raster::fitted_camera(camera, 10, 10, 20, 0), DomainError);
  CHECK_THROWS_WITH(
      raster::fitted_camera(camera, image::Placement{0, 10, 0, 0}, 20, 20),
      "fitted_camera: a photograph of 0 x 10 pixels on a canvas of 20 x 20, expected at least 1 x 1");
}

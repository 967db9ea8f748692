#include "../../examples/scenes/photograph.hpp"

#include "../support/catch.hpp"

using namespace tapestry;

TEST_CASE("a photograph's camera sees the ground as a pinhole at its height does", "[scenes][photograph]") {
  scenes::PhotographOptions options;
  options.camera_height_m = 2;
  options.fov_deg = 90;
  for (const double pitch_deg : {0.0, 30.0})
    for (const double yaw : {0.0, 2.0}) {
      options.pitch_deg = pitch_deg;
      const auto camera = scenes::photograph_camera(options, 8, 3, yaw, 4.0 / 3);
      CHECK(camera.tan_half_fov_x == Approx(1));
      CHECK(camera.tan_half_fov_y == Approx(0.75));
      // The car's origin, on the ground 8 m ahead and 3 m to the left; then 1 m further along the car's axis.
      const double c = std::cos(pitch_deg * std::numbers::pi / 180),
                   s = std::sin(pitch_deg * std::numbers::pi / 180);
      for (const double along : {0.0, 1.0}) {
        const double ahead = 8 + along * std::cos(yaw), left = 3 + along * std::sin(yaw);
        const auto q = geometry::view_from_world(camera, {along, 0, 0});
        CHECK(q[0] == Approx(-left));
        CHECK(q[1] == Approx(2 * c - ahead * s));
        CHECK(q[2] == Approx(ahead * c + 2 * s));
      }
    }
}

TEST_CASE("photographs keep their shape and their mean when they are resized", "[scenes][photograph]") {
  Array<float, 3> picture(Extents<3>{90, 160, 3});
  for (std::size_t i = 0; i < picture.size(); ++i) picture.data()[i] = i / 3 % 2 == 0 ? 1.0F : 0.0F;
  const auto small = scenes::resized_photograph(picture, 40);
  REQUIRE(small.shape(1) == 40);
  CHECK((small.shape(0) == 22 || small.shape(0) == 23));
  for (const float value : small) CHECK(value == Approx(0.5));  // columns of one pixel, black and white
  CHECK(scenes::resized_photograph(picture, 320).shape(0) == 180);
}

TEST_CASE("a lens of 36 mm sees half its width by its length, less on its side", "[scenes][photograph]") {
  // 36 × 24 mm film: half of 36 mm by 36 mm, and half of 24 mm for a picture on its side.
  CHECK(scenes::fov_of_lens_deg(36, 24, 36) == Approx(2 * 180 / 3.141592653589793 * std::atan(0.5)));
  CHECK(scenes::fov_of_lens_deg(12, 36, 24) == Approx(90));
}

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

namespace {
/// A level photograph of 90 degrees from 1.5 m: white sky above the horizon, ground below, of another colour
/// from `nearest` to `farthest` metres ahead.
Array<float, 3> street(const scenes::Colour& ground, const scenes::Colour& band = {}, double nearest = 0,
                       double farthest = 0) {
  Array<float, 3> picture(Extents<3>{100, 100, 3});
  for (std::size_t row = 0; row < 100; ++row) {
    const double ahead = 1.5 * 50 / (static_cast<double>(row) + 0.5 - 50);
    for (std::size_t i = 0; i < 300; ++i)
      picture(row, i / 3, i % 3) = ahead < 0                               ? 1.0F
                                   : ahead >= nearest && ahead <= farthest ? band[i % 3]
                                                                           : ground[i % 3];
  }
  return picture;
}

/// Light that a level white surface returns in each channel.
std::array<double, 3> on_level(const raster::Light& light) {
  const double level = light.ambient + light.directional * light.direction[2];
  return {level * light.colour[0], level * light.colour[1], level * light.colour[2]};
}
}  // namespace

TEST_CASE("the light on a car gives the asphalt around it the photograph's colour", "[scenes][photograph]") {
  scenes::PhotographOptions options;
  options.fov_deg = 90;
  const auto camera = scenes::photograph_camera(options, 8, 1, 0.5, 1);
  raster::Light sun;
  sun.direction = {0.6, 0, 0.8};
  sun.directional = 0.5;
  sun.ambient = 0.6;
  for (const auto& ground : {scenes::Colour{0.4F, 0.4F, 0.4F}, scenes::Colour{0.2F, 0.22F, 0.24F}}) {
    const auto light = scenes::light_of_ground(sun, street(ground), camera);
    for (std::size_t c = 0; c < 3; ++c)
      CHECK(on_level(light)[c] * scenes::asphalt == Approx(static_cast<double>(ground[c])));
    CHECK(light.directional / light.ambient == Approx(sun.directional / sun.ambient));  // as before
    CHECK(light.direction == sun.direction);
  }

  const scenes::Colour light_grey{0.5F, 0.5F, 0.5F}, dark_grey{0.2F, 0.2F, 0.2F};
  const auto shaded = scenes::light_of_ground(sun, street(light_grey, dark_grey, 4, 12), camera);
  CHECK(shaded.directional == 0);  // in the shade of something
  CHECK(on_level(shaded)[1] * scenes::asphalt == Approx(0.2));
  CHECK(scenes::light_of_ground(sun, street(dark_grey, light_grey, 4, 12), camera).directional > 0);
  CHECK(scenes::light_of_ground(sun, street(light_grey, dark_grey, 20, 99), camera).directional > 0);

  // Ends: night, overexposure, grass, no ground in view.
  CHECK(on_level(scenes::light_of_ground(sun, street({}), camera))[0] == Approx(0.15));
  CHECK(on_level(scenes::light_of_ground(sun, street({1, 1, 1}), camera))[0] == Approx(1.3));
  const auto grass = scenes::light_of_ground(sun, street({0.1F, 0.6F, 0.1F}), camera);
  CHECK((grass.colour[0] == 0.8 && grass.colour[1] == 1.2));
  options.pitch_deg = -45;
  const auto unseen =
      scenes::light_of_ground(sun, street({}), scenes::photograph_camera(options, 8, 1, 0, 1));
  CHECK((unseen.ambient == sun.ambient && unseen.directional == sun.directional));
}

#include <cmath>
#include <limits>
#include <numbers>
#include <tapestry/geometry/camera.hpp>

#include "../support/catch.hpp"

namespace geometry = tapestry::geometry;
using geometry::Vector3;

namespace {
constexpr double right_angle = std::numbers::pi / 2;

double distance_from_rotation(const geometry::Camera& camera) {
  const auto& [x, y, z] = camera.rotation;
  double error = geometry::length(geometry::subtract(geometry::cross(x, y), z));
  for (const Vector3& axis : camera.rotation) error = std::max(error, std::abs(geometry::length(axis) - 1));
  return std::max({error, std::abs(geometry::dot(x, y)), std::abs(geometry::dot(y, z))});
}
}  // namespace

TEST_CASE("look_at puts what is left in the world to the left in the picture", "[geometry][camera]") {
  // From in front of the car (+x), looking back at it: its left side (+y) is on the right of the picture.
  const auto camera = geometry::look_at({5, 0, 0}, {0, 0, 0}, {0, 0, 1}, right_angle);
  CHECK(distance_from_rotation(camera) <= 1e-12);
  const auto target =
      geometry::picture_from_view(camera, geometry::view_from_world(camera, {0, 0, 0}), 100, 200);
  CHECK(target[0] == Approx(50));
  CHECK(target[1] == Approx(100));
  const auto left_and_up =
      geometry::picture_from_view(camera, geometry::view_from_world(camera, {0, 5, 2.5}), 100, 200);
  CHECK(left_and_up[0] == Approx(25));
  CHECK(left_and_up[1] == Approx(200));
  CHECK(geometry::length(geometry::subtract(geometry::eye_of(camera), {5, 0, 0})) <= 1e-12);
}

TEST_CASE("look_at takes two fields of view", "[geometry][camera]") {
  const auto camera = geometry::look_at({0, 0, 0}, {1, 0, 0}, {0, 0, 1}, right_angle, right_angle / 3);
  CHECK(camera.tan_half_fov_x == Approx(1));
  CHECK(camera.tan_half_fov_y == Approx(std::tan(right_angle / 6)));
}

TEST_CASE("orbit_camera looks at its target from any side, straight above too", "[geometry][camera]") {
  for (const double azimuth : {0.0, 1.0, 4.0}) {
    for (const double elevation : {-right_angle, -0.3, 0.0, 1.2, right_angle}) {
      const auto camera = geometry::orbit_camera(azimuth, elevation, 3, {1, 2, 3}, 1);
      CHECK(distance_from_rotation(camera) <= 1e-12);
      const Vector3 target = geometry::view_from_world(camera, {1, 2, 3});
      CHECK(geometry::length(geometry::subtract(target, {0, 0, 3})) <= 1e-12);
    }
  }
  const Vector3 eye = geometry::eye_of(geometry::orbit_camera(right_angle, 0, 2, {0, 0, 0}, 1));
  CHECK(geometry::length(geometry::subtract(eye, {0, 2, 0})) <= 1e-12);
}

TEST_CASE("cameras that make no sense are refused", "[geometry][camera]") {
  CHECK_THROWS_AS(geometry::look_at({1, 1, 1}, {1, 1, 1}, {0, 0, 1}, 1), tapestry::DomainError);
  CHECK_THROWS_AS(geometry::look_at({0, 0, 0}, {0, 0, 2}, {0, 0, 1}, 1), tapestry::DomainError);
  CHECK_THROWS_AS(geometry::look_at({0, 0, 0}, {1, 0, 0}, {0, 0, 1}, 0), tapestry::DomainError);
  CHECK_THROWS_AS(geometry::look_at({0, 0, 0}, {1, 0, 0}, {0, 0, 1}, 4), tapestry::DomainError);
  CHECK_THROWS_AS(geometry::look_at({std::nan(""), 0, 0}, {1, 0, 0}, {0, 0, 1}, 1), tapestry::DomainError);
  CHECK_THROWS_AS(geometry::orbit_camera(0, 0, 0, {0, 0, 0}, 1), tapestry::DomainError);
}

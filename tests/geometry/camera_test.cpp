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

TEST_CASE("orbit_of finds the orbit back, also for cameras that look elsewhere", "[geometry][camera]") {
  const Vector3 target{1, 2, 3};
  for (const double azimuth : {-3.0, -0.4, 0.0, 1.0, 3.1}) {
    for (const double elevation : {-1.5, -0.3, 0.0, 1.2}) {
      const auto orbit = geometry::orbit_of(geometry::orbit_camera(azimuth, elevation, 3, target, 1), target);
      CHECK(std::abs(orbit.azimuth_rad - azimuth) <= 1e-12 / std::cos(elevation));
      CHECK(std::abs(orbit.elevation_rad - elevation) <= 1e-12);
      CHECK(std::abs(orbit.distance - 3) <= 1e-12);
    }
  }
  const auto aside = geometry::orbit_of(geometry::look_at({1, 7, 3}, {9, 9, 9}, {0, 0, 1}, 1), target);
  CHECK(aside.azimuth_rad == Approx(right_angle));
  CHECK(aside.distance == Approx(5));
  const auto above = geometry::orbit_of(geometry::orbit_camera(0.7, right_angle, 2, {0, 0, 0}, 1), {0, 0, 0});
  CHECK(above.azimuth_rad == 0);
  CHECK(above.elevation_rad == Approx(right_angle));
  CHECK_THROWS_AS(geometry::orbit_of({}, {0, 0, 0}), tapestry::DomainError);
}

TEST_CASE("Neural Mesh Renderer's camera mirrors a right-handed world", "[geometry][camera]") {
  const double half = std::numbers::pi / 6;
  const auto camera = geometry::neural_mesh_renderer_camera(0, 0, 2.732);  // its default eye, (0, 0, −2.732)
  CHECK(geometry::length(geometry::subtract(geometry::eye_of(camera), {0, 0, -2.732})) <= 1e-12);
  // Its rule for a vertex: x right and y up, each over z · tan 30°, with z = 2.732 + 0.4.
  const auto found =
      geometry::picture_from_view(camera, geometry::view_from_world(camera, {0.3, 0.2, 0.4}), 2, 2);
  CHECK(found[0] - 1 == Approx(-0.2 / (3.132 * std::tan(half))));
  CHECK(found[1] - 1 == Approx(0.3 / (3.132 * std::tan(half))));
  const auto eye = geometry::eye_of(geometry::neural_mesh_renderer_camera(right_angle, right_angle / 3, 4));
  CHECK(geometry::length(geometry::subtract(eye, {4 * std::cos(right_angle / 3), 2, 0})) <= 1e-12);
  CHECK_THROWS_AS(geometry::neural_mesh_renderer_camera(0, right_angle, 1), tapestry::DomainError);
  CHECK_THROWS_AS(geometry::neural_mesh_renderer_camera(0, 0, -1), tapestry::DomainError);
  CHECK_THROWS_AS(geometry::neural_mesh_renderer_camera(0, 0, 1, 2), tapestry::DomainError);
}

TEST_CASE("cameras that make no sense are refused", "[geometry][camera]") {  // T07
  CHECK_THROWS_AS(geometry::look_at({1, 1, 1}, {1, 1, 1}, {0, 0, 1}, 1), tapestry::DomainError);
  CHECK_THROWS_AS(geometry::look_at({0, 0, 0}, {0, 0, 2}, {0, 0, 1}, 1), tapestry::DomainError);
  CHECK_THROWS_AS(geometry::look_at({0, 0, 0}, {1, 0, 0}, {0, 0, 1}, 0), tapestry::DomainError);
  CHECK_THROWS_AS(geometry::look_at({0, 0, 0}, {1, 0, 0}, {0, 0, 1}, 4), tapestry::DomainError);
  CHECK_THROWS_AS(geometry::look_at({std::nan(""), 0, 0}, {1, 0, 0}, {0, 0, 1}, 1), tapestry::DomainError);
  CHECK_THROWS_AS(geometry::orbit_camera(0, 0, 0, {0, 0, 0}, 1), tapestry::DomainError);
}

#include <limits>
#include <tapestry/geometry/pose.hpp>

#include "../support/catch.hpp"

namespace geometry = tapestry::geometry;
using geometry::Vector3;

TEST_CASE("carla_camera flips y once: CARLA's right is the mesh's −y", "[geometry][carla]") {
  // 5 m to the right of a vehicle that looks along +x, looking left at it.
  const auto camera = geometry::carla_camera({{7, 8, 0.6}, {0, 0, 0}, {0, 5, 0.2}, {0, -90, 0}});
  const Vector3 eye = geometry::eye_of(camera);
  CHECK(geometry::length(geometry::subtract(eye, {0, -5 * 0.41, 0})) <= 1e-12);
  const Vector3 front =
      geometry::view_from_world(camera, {1, 0, 0});  // seen from its right the car faces right
  CHECK(geometry::length(geometry::subtract(front, {1, 0, 5 * 0.41})) <= 1e-12);
  const Vector3 roof = geometry::view_from_world(camera, {0, 0, 1});
  CHECK(geometry::length(geometry::subtract(roof, {0, -1, 5 * 0.41})) <= 1e-12);
}

TEST_CASE("turning vehicle and camera together changes nothing", "[geometry][carla]") {
  const auto still = geometry::carla_camera({{0, 0, 0}, {0, 0, 0}, {-4, 0, 2}, {-25, 0, 0}});
  const double turn = 0.5235987755982988;  // 30°
  const auto turned = geometry::carla_camera(
      {{0, 0, 0}, {0, 30, 0}, {-4 * std::cos(turn), -4 * std::sin(turn), 2}, {-25, 30, 0}});
  for (std::size_t row = 0; row < 3; ++row) {
    CHECK(geometry::length(geometry::subtract(still.rotation[row], turned.rotation[row])) <= 1e-12);
  }
  CHECK(geometry::length(geometry::subtract(still.translation, turned.translation)) <= 1e-12);
}

TEST_CASE("carla_camera refuses numbers that are not finite", "[geometry][carla]") {
  CHECK_THROWS_AS(geometry::carla_camera({{}, {}, {5, 0, 0}, {0, std::nan(""), 0}}), tapestry::DomainError);
  CHECK_THROWS_AS(geometry::carla_camera({{}, {}, {std::nan(""), 0, 0}, {0, 0, 0}}), tapestry::DomainError);
}

TEST_CASE("normalise_mesh centres the box and makes its longest half extent 1", "[geometry][carla]") {
  geometry::Mesh mesh;
  mesh.positions = {{10, 1, 0}, {14, 3, 1}, {12, 2, std::numeric_limits<double>::quiet_NaN()}};
  const auto normal = geometry::normalise_mesh(mesh);
  CHECK(geometry::length(geometry::subtract(normal.positions[0], {-1, -0.5, -0.25})) <= 1e-15);
  CHECK(geometry::length(geometry::subtract(normal.positions[1], {1, 0.5, 0.25})) <= 1e-15);
  CHECK(geometry::normalise_mesh(geometry::Mesh{}).positions.empty());
}

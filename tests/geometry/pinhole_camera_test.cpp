#include <limits>
#include <tapestry/core/random.hpp>
#include <tapestry/geometry/camera.hpp>

#include "../support/catch.hpp"

namespace geometry = tapestry::geometry;
using geometry::Vector3;

namespace {
const auto pose = geometry::look_at({3, -2, 1.5}, {0.2, 0.1, 0}, {0, 0, 1}, 1);

double distance_between(const Vector3& a, const Vector3& b) {
  return geometry::length(geometry::subtract(a, b));
}
}  // namespace

TEST_CASE("pinhole_camera projects as its intrinsics say", "[geometry][camera]") {
  const geometry::Intrinsics k{410, 395.5, 333, 190.25, 640, 360, -2.5};
  const auto camera = geometry::pinhole_camera(k, pose.rotation, pose.translation);
  tapestry::Random random(1);
  for (int round = 0; round < 100; ++round) {
    const Vector3 point{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
    const Vector3 view = geometry::view_from_world(pose, point);
    const auto found =
        geometry::picture_from_view(camera, geometry::view_from_world(camera, point), k.height, k.width);
    CHECK(std::abs(found[1] - ((k.focal_x * view[0] + k.skew * view[1]) / view[2] + k.centre_x)) <= 1e-9);
    CHECK(std::abs(found[0] - (k.focal_y * view[1] / view[2] + k.centre_y)) <= 1e-9);
  }
  CHECK(distance_between(geometry::eye_of(camera), {3, -2, 1.5}) <= 1e-12);
}

TEST_CASE("pinhole_camera is the symmetric camera where the principal point is in the middle",
          "[geometry][camera]") {
  const auto k = geometry::intrinsics_of(pose, 300, 200);
  const auto camera = geometry::pinhole_camera(k, pose.rotation, pose.translation);
  CHECK(camera.tan_half_fov_x == Approx(pose.tan_half_fov_x));
  CHECK(camera.tan_half_fov_y == Approx(pose.tan_half_fov_y));
  for (std::size_t i = 0; i < 3; ++i) CHECK(distance_between(camera.rotation[i], pose.rotation[i]) <= 1e-15);
}

TEST_CASE("pinhole_camera refuses what is no camera", "[geometry][camera][bad_input]") {
  const geometry::Intrinsics sound{100, 100, 50, 40, 100, 80};
  const auto make = [&](auto change) {
    auto k = sound;
    auto rotation = pose.rotation;
    change(k, rotation);
    return geometry::pinhole_camera(k, rotation, pose.translation);
  };
  CHECK_NOTHROW(make([](auto&, auto&) {}));
  CHECK_THROWS_AS(make([](auto& k, auto&) { k.focal_x = 0; }), tapestry::DomainError);
  CHECK_THROWS_AS(make([](auto& k, auto&) { k.focal_y = -1; }), tapestry::DomainError);
  CHECK_THROWS_AS(make([](auto& k, auto&) { k.width = 0; }), tapestry::DomainError);
  CHECK_THROWS_AS(make([](auto& k, auto&) { k.centre_x = std::nan(""); }), tapestry::DomainError);
  CHECK_THROWS_AS(make([](auto& k, auto&) { k.skew = std::numeric_limits<double>::infinity(); }),
                  tapestry::DomainError);
  CHECK_THROWS_WITH(make([](auto&, auto& rotation) {
                      rotation[1] = {0, 0, 2};
                    }),
                    "pinhole_camera: the rows of R must be orthonormal");
  CHECK_THROWS_AS(geometry::pinhole_camera(sound, pose.rotation, {0, std::nan(""), 0}),
                  tapestry::DomainError);
}

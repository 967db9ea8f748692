#include <tapestry/geometry/pose.hpp>

#include <tapestry/core/random.hpp>

#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"

namespace geometry = tapestry::geometry;
using geometry::Camera, geometry::Pose, geometry::Vector3, tapestry::test::slope_by;

namespace {
/// A camera whose rotation has a shear in it, as one has whose axis misses the middle of its picture.
Camera sheared_camera() {
  const Camera straight = geometry::orbit_camera(0.7, 0.3, 4, {0.1, 0.2, 0.3}, 1);
  return geometry::pinhole_camera({300, 280, 90, 150, 200, 220, 5}, straight.rotation, straight.translation);
}
}  // namespace

TEST_CASE("a posed camera sees points where the camera sees them once they are posed", "[geometry][pose]") {
  const Camera camera = sheared_camera();
  const Pose pose{{0.4, -1.1, 2.3}, {0.5, -0.2, 0.9}};
  const Vector3 point{0.3, -0.8, 1.7};
  const Vector3 moved =
      geometry::add(geometry::multiply(geometry::exponential_map(pose.rotation), point), pose.translation);
  const Vector3 expected = geometry::view_from_world(camera, moved);
  const Vector3 found = geometry::view_from_world(geometry::posed(camera, pose), point);
  CHECK(geometry::length(geometry::subtract(found, expected)) <= 1e-14);
  CHECK(geometry::posed(camera, {}).rotation == camera.rotation);
  CHECK(geometry::posed(camera, {}).translation == camera.translation);
}

TEST_CASE("posed_adjoint agrees with central differences of what a camera sees",
          "[geometry][pose][gradient]") {
  const Camera camera = sheared_camera();
  tapestry::Random random(1);
  const auto draw = [&] {
    return Vector3{random.uniform(-1, 1), random.uniform(-1, 1), random.uniform(-1, 1)};
  };
  std::vector<Vector3> points(5), weights(5);
  for (std::size_t i = 0; i < 5; ++i) points[i] = draw(), weights[i] = draw();
  for (const Pose& pose : {Pose{}, Pose{draw(), draw()}, Pose{{0, 3.14159, 0}, draw()}}) {
    const auto loss = [&](const Pose& at) {  // Σ weights · x_view²
      double sum = 0;
      for (std::size_t i = 0; i < points.size(); ++i) {
        const Vector3 q = geometry::view_from_world(geometry::posed(camera, at), points[i]);
        for (std::size_t k = 0; k < 3; ++k) sum += weights[i][k] * q[k] * q[k];
      }
      return sum;
    };
    const Camera seen = geometry::posed(camera, pose);
    std::vector<Vector3> positions = points, gradient(5);
    for (std::size_t i = 0; i < 5; ++i) {
      Vector3 at_view = geometry::view_from_world(seen, points[i]);
      for (std::size_t k = 0; k < 3; ++k) at_view[k] *= 2 * weights[i][k];
      gradient[i] = geometry::multiply_transposed(seen.rotation, at_view);
    }
    positions.push_back({std::nan(""), 0, 0});  // seen by nobody
    gradient.push_back({0, 0, 0});
    Pose found{{1, 1, 1}, {1, 1, 1}};  // the adjoint adds
    geometry::posed_adjoint(pose, positions, gradient, found);
    Pose at = pose;
    const auto value = [&] { return loss(at); };
    for (std::size_t axis = 0; axis < 3; ++axis) {
      CHECK(found.rotation[axis] - 1 == Approx(slope_by(at.rotation[axis], 1e-5, value)).margin(1e-7));
      CHECK(found.translation[axis] - 1 == Approx(slope_by(at.translation[axis], 1e-5, value)).margin(1e-7));
    }
  }
}

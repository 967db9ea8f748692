#pragma once
#include <array>
#include <cmath>
#include <numbers>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/geometry/transform.hpp>

namespace tapestry::geometry {

/// A pinhole camera without a resolution: pictures of any size share it.
///
/// View space has x to the right, y down and z forward (right-handed), in the units of the world.
/// A point p of the world has the view coordinates q = R·p + t and the picture coordinates
///   column = (1 + q.x / (q.z · tan_half_fov_x)) / 2 · width,
///   row    = (1 + q.y / (q.z · tan_half_fov_y)) / 2 · height;
/// pixel (row i, column j) covers [j, j+1) × [i, i+1), its centre is at +½.
struct Camera {
  std::array<std::array<double, 3>, 3> rotation{{{1, 0, 0}, {0, 1, 0}, {0, 0, 1}}};  ///< R, view_from_world
  std::array<double, 3> translation{0, 0, 0};                                        ///< t, view_from_world
  double tan_half_fov_x = 1;
  double tan_half_fov_y = 1;
  double near = 0.1;  ///< nearer surfaces are clipped; world units
  double far = 1000;  ///< farther surfaces are not drawn; world units
};

/// q = R·p + t
[[nodiscard]] inline Vector3 view_from_world(const Camera& camera, const Vector3& point_world) {
  return add(multiply(camera.rotation, point_world), camera.translation);
}

/// The camera's centre in the world, −Rᵀ·t.
[[nodiscard]] inline Vector3 eye_of(const Camera& camera) {
  return scale(multiply_transposed(camera.rotation, camera.translation), -1);
}

/// {row, column} of a point of view space in a picture of the given size; meaningful for z > 0.
[[nodiscard]] inline std::array<double, 2> picture_from_view(const Camera& camera, const Vector3& point_view,
                                                             double height, double width) {
  return {(1 + point_view[1] / (point_view[2] * camera.tan_half_fov_y)) / 2 * height,
          (1 + point_view[0] / (point_view[2] * camera.tan_half_fov_x)) / 2 * width};
}

namespace detail {
inline double tan_half(const char* operation, double fov_rad) {
  if (!(fov_rad > 0 && fov_rad < std::numbers::pi)) {
    throw DomainError(std::string(operation) + ": field of view is " + std::to_string(fov_rad) +
                      " rad, expected more than 0 and less than pi");
  }
  return std::tan(fov_rad / 2);
}
}  // namespace detail

/// Camera at `eye_world` that looks along `forward_world`, with `up_world` upwards in the picture. The
/// field of view is left at 90°.
///
/// \throws DomainError if forward has no length, or is parallel to up
[[nodiscard]] inline Camera look_along(const Vector3& eye_world, const Vector3& forward_world,
                                       const Vector3& up_world) {
  const Vector3 forward = normalised(forward_world);
  const Vector3 side = cross(forward, normalised(up_world));
  if (!is_finite(eye_world) || !(length(forward) > 0.5) || !(length(side) > 1e-9)) {
    throw DomainError("look_along: eye must be finite, forward and up must have a length and differ");
  }
  Camera camera;
  const Vector3 right = normalised(side);
  camera.rotation = {right, cross(forward, right), forward};
  camera.translation = scale(multiply(camera.rotation, eye_world), -1);
  return camera;
}

/// Camera at `eye_world` with `target_world` at the centre of the picture.
///
/// \param fov_x_rad  full horizontal field of view
/// \param fov_y_rad  full vertical field of view
/// \throws DomainError if the target is at the eye, above or below it along up, or a field of view is
///         not between 0 and pi
[[nodiscard]] inline Camera look_at(const Vector3& eye_world, const Vector3& target_world,
                                    const Vector3& up_world, double fov_x_rad, double fov_y_rad) {
  Camera camera = look_along(eye_world, subtract(target_world, eye_world), up_world);
  camera.tan_half_fov_x = detail::tan_half("look_at", fov_x_rad);
  camera.tan_half_fov_y = detail::tan_half("look_at", fov_y_rad);
  return camera;
}

/// look_at() for square pictures.
[[nodiscard]] inline Camera look_at(const Vector3& eye_world, const Vector3& target_world,
                                    const Vector3& up_world, double fov_rad) {
  return look_at(eye_world, target_world, up_world, fov_rad, fov_rad);
}

/// Camera on a sphere around `target_world`, for square pictures.
///
/// The eye is target + distance · (cos e · cos a, cos e · sin a, sin e): azimuth a = 0 lies in front of
/// a car whose front is +x and grows towards its left (+y), elevation e = π/2 is straight above. Any
/// elevation works, since up is the direction in which the elevation grows.
///
/// \throws DomainError if distance is not positive or the field of view not between 0 and pi
[[nodiscard]] inline Camera orbit_camera(double azimuth_rad, double elevation_rad, double distance,
                                         const Vector3& target_world, double fov_rad) {
  if (!(distance > 0)) throw DomainError("orbit_camera: distance must be positive");
  const double ca = std::cos(azimuth_rad), sa = std::sin(azimuth_rad);
  const double ce = std::cos(elevation_rad), se = std::sin(elevation_rad);
  const Vector3 outward{ce * ca, ce * sa, se};
  Camera camera =
      look_along(add(target_world, scale(outward, distance)), scale(outward, -1), {-se * ca, -se * sa, ce});
  camera.tan_half_fov_x = camera.tan_half_fov_y = detail::tan_half("orbit_camera", fov_rad);
  return camera;
}

}  // namespace tapestry::geometry

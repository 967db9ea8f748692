#pragma once
#include <numbers>
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
///
/// R is a rotation, with two exceptions: a camera whose axis misses the picture's centre has a shear along z
/// in it, see pinhole_camera(), and one of Neural Mesh Renderer's left-handed axes a reflection.
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

/// The camera's centre in the world, −R⁻¹·t.
[[nodiscard]] inline Vector3 eye_of(const Camera& camera) {
  const auto& [x, y, z] = camera.rotation;
  const bool is_orthogonal =
      std::abs(dot(x, y)) + std::abs(dot(y, z)) + std::abs(dot(z, x)) <= 1e-12 * length(x) * length(y);
  if (is_orthogonal) return scale(multiply_transposed(camera.rotation, camera.translation), -1);
  const auto& t = camera.translation;
  const Vector3 sum = add(add(scale(cross(y, z), t[0]), scale(cross(z, x), t[1])), scale(cross(x, y), t[2]));
  return scale(sum, -1 / dot(x, cross(y, z)));
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
    throw DomainError(
        {operation, ": field of view is ", fov_rad, " rad, expected more than 0 and less than pi"});
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
/// elevation works: up is the direction of growing elevation.
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

/// Place of a camera around a point, in the terms of orbit_camera().
struct Orbit {
  double azimuth_rad;    ///< in (−π, π], 0 straight above or below
  double elevation_rad;  ///< in [−π/2, π/2]
  double distance;
};

/// The orbit of a camera's centre; the camera's direction does not matter.
/// \throws DomainError if the centre is at the target, or not finite
[[nodiscard]] inline Orbit orbit_of(const Camera& camera, const Vector3& target_world) {
  const Vector3 offset = subtract(eye_of(camera), target_world);
  const double distance = length(offset);
  if (!(distance > 0) || !std::isfinite(distance))
    throw DomainError("orbit_of: the camera's centre must be finite and not at the target");
  const double across = std::hypot(offset[0], offset[1]);
  const bool is_above = across <= 1e-15 * distance;
  return {is_above ? 0 : std::atan2(offset[1], offset[0]), std::atan2(offset[2], across), distance};
}

/// The camera of Neural Mesh Renderer's get_points_from_angles() and look_at mode, for square pictures of
/// meshes whose y is up: the eye is distance · (cos e · sin a, sin e, −cos e · cos a), it looks at the
/// origin. Its axes are left-handed, so a right-handed mesh appears mirrored, as it does there.
///
/// \param half_fov_rad  viewing_angle of the source, half of the field of view; its default is π/6
/// \throws DomainError if distance is not positive, the eye is straight above or below the origin, or half
///         the field of view is not between 0 and π/2
[[nodiscard]] inline Camera neural_mesh_renderer_camera(double azimuth_rad, double elevation_rad,
                                                        double distance,
                                                        double half_fov_rad = std::numbers::pi / 6) {
  if (!(distance > 0)) throw DomainError("neural_mesh_renderer_camera: distance must be positive");
  const double ce = std::cos(elevation_rad);
  const Vector3 eye =
      scale({ce * std::sin(azimuth_rad), std::sin(elevation_rad), -ce * std::cos(azimuth_rad)}, distance);
  Camera camera = look_along(eye, scale(eye, -1), {0, 1, 0});
  camera.rotation[0] = scale(camera.rotation[0], -1);
  camera.translation = scale(multiply(camera.rotation, eye), -1);
  camera.tan_half_fov_x = camera.tan_half_fov_y =
      detail::tan_half("neural_mesh_renderer_camera", 2 * half_fov_rad);
  return camera;
}

/// Intrinsic parameters of a calibrated camera: they map view space to pixels of one picture.
///   column = (focal_x · x + skew · y) / z + centre_x,   row = focal_y · y / z + centre_y.
/// Pixel (row i, column j) covers [j, j+1) × [i, i+1). Tools that put whole numbers at the centres of pixels,
/// as OpenCV does, state a centre that is smaller by ½.
struct Intrinsics {
  double focal_x;
  double focal_y;
  double centre_x;  ///< column of the principal point
  double centre_y;  ///< row of the principal point
  double width;     ///< of the picture
  double height;
  double skew = 0;
};

/// Camera with given intrinsics and pose. A principal point beside the picture's centre, and skew, become a
/// shear in view_from_world, which changes neither depth nor visibility; so every function that takes a
/// camera takes this one.
///
/// \param view_from_world  R, a rotation into x to the right, y down, z forward
/// \param translation      t, view_from_world
/// \throws DomainError unless all is finite, focal lengths, width and height are positive and R is
///         orthonormal
[[nodiscard]] inline Camera pinhole_camera(const Intrinsics& intrinsics, const Matrix3& view_from_world,
                                           const Vector3& translation) {
  const auto& k = intrinsics;
  const auto fail = [](const char* what) { throw DomainError({"pinhole_camera: ", what}); };
  if (!(k.focal_x > 0) || !(k.focal_y > 0) || !is_finite({k.focal_x, k.focal_y, k.skew}))
    fail("focal lengths must be positive and finite, and skew finite");
  if (!(k.width > 0) || !(k.height > 0) || !is_finite({k.width, k.height, 0}))
    fail("width and height must be positive and finite");
  if (!is_finite({k.centre_x, k.centre_y, 0})) fail("the principal point must be finite");
  if (!is_orthonormal(view_from_world)) fail("the rows of R must be orthonormal");
  if (!is_finite(translation)) fail("the translation must be finite");
  Camera camera;
  camera.tan_half_fov_x = k.width / (2 * k.focal_x);
  camera.tan_half_fov_y = k.height / (2 * k.focal_y);
  const Matrix3 shear{{{1, k.skew / k.focal_x, (k.centre_x - k.width / 2) / k.focal_x},
                       {0, 1, (k.centre_y - k.height / 2) / k.focal_y},
                       {0, 0, 1}}};
  for (std::size_t i = 0; i < 3; ++i) camera.rotation[i] = multiply_transposed(view_from_world, shear[i]);
  camera.translation = multiply(shear, translation);
  return camera;
}

/// The intrinsics of a symmetric camera for pictures of the given size.
[[nodiscard]] inline Intrinsics intrinsics_of(const Camera& camera, double width, double height) {
  return {width / (2 * camera.tan_half_fov_x),
          height / (2 * camera.tan_half_fov_y),
          width / 2,
          height / 2,
          width,
          height,
          0};
}
}  // namespace tapestry::geometry

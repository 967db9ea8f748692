#pragma once
#include <cmath>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/geometry/camera.hpp>
#include <tapestry/geometry/transform.hpp>

namespace tapestry::geometry {

/// What a calibrated camera makes of view space, in pixels of one picture:
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

/// Camera with given intrinsics and pose. A principal point beside the picture's centre, and skew, go into
/// view_from_world as a shear, which changes neither depth nor what is seen; so all that takes a camera
/// takes this one.
///
/// \param view_from_world  R, a rotation into x to the right, y down, z forward
/// \param translation      t, view_from_world
/// \throws DomainError unless all is finite, focal lengths, width and height are positive and R is
/// orthonormal
[[nodiscard]] inline Camera pinhole_camera(const Intrinsics& intrinsics, const Matrix3& view_from_world,
                                           const Vector3& translation) {
  const auto& k = intrinsics;
  const auto fail = [](const char* what) { throw DomainError(std::string("pinhole_camera: ") + what); };
  if (!(k.focal_x > 0) || !(k.focal_y > 0) || !is_finite({k.focal_x, k.focal_y, k.skew}))
    fail("focal lengths must be positive and finite, and skew finite");
  if (!(k.width > 0) || !(k.height > 0) || !is_finite({k.width, k.height, 0}))
    fail("width and height must be positive and finite");
  if (!is_finite({k.centre_x, k.centre_y, 0})) fail("the principal point must be finite");
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j) {
      const double product = dot(view_from_world[i], view_from_world[j]);
      if (!(std::abs(product - (i == j ? 1 : 0)) <= 1e-6)) fail("the rows of R must be orthonormal");
    }
  }
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

/// Half the width over the focal length, and so on: the intrinsics that make a symmetric camera's pictures of
/// the given size.
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

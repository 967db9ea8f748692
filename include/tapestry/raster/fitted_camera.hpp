#pragma once
#include <tapestry/geometry/camera.hpp>
#include <tapestry/image/letterbox.hpp>

namespace tapestry::raster {
/// Camera that sees a photograph in its place on a canvas, such as a detector's square input.
///
/// With e the canvas' extent along an axis, p the photograph's on the canvas and b the margin before it, the
/// field of view grows with the margins, and a photograph off the middle shears the view:
///
///   tan' = tan · e / p,   q'[axis] = q[axis] + tan' · (2·b + p − e) / e · q.z
///
/// so that a point at the share s of the photograph is at pixel b + s · p of the canvas. Depth stays. See
/// geometry::pinhole_camera() for cameras with a shear.
///
/// \param camera         of the photograph
/// \param place          of the photograph on the canvas, pixels, see image::placement()
/// \param height, width  of the canvas, pixels
/// \throws DomainError if an extent is 0
[[nodiscard]] inline geometry::Camera fitted_camera(geometry::Camera camera, const image::Placement& place,
                                                    std::size_t height, std::size_t width) {
  if (place.height == 0 || place.width == 0 || height == 0 || width == 0)
    throw DomainError({"fitted_camera: a photograph of ", place.height, " x ", place.width,
                       " pixels on a canvas of ", height, " x ", width, ", expected at least 1 x 1"});
  const auto fit_axis = [&](std::size_t axis, double& tan_half_fov, std::size_t extent, std::size_t placed,
                            std::size_t before) {
    const auto whole = static_cast<double>(extent);
    tan_half_fov *= whole / static_cast<double>(placed);
    const double shift = 2 * static_cast<double>(before) + static_cast<double>(placed) - whole;
    if (shift == 0) return;
    const double shear = tan_half_fov * shift / whole;
    for (std::size_t i = 0; i < 3; ++i) camera.rotation[axis][i] += shear * camera.rotation[2][i];
    camera.translation[axis] += shear * camera.translation[2];
  };
  fit_axis(0, camera.tan_half_fov_x, width, place.width, place.left);
  fit_axis(1, camera.tan_half_fov_y, height, place.height, place.top);
  return camera;
}

/// The same for a photograph of photo_height × photo_width pixels that goes onto the canvas by
/// image::fitted(). \throws DomainError if an extent is 0
[[nodiscard]] inline geometry::Camera fitted_camera(const geometry::Camera& camera, std::size_t photo_height,
                                                    std::size_t photo_width, std::size_t height,
                                                    std::size_t width,
                                                    image::FitKind kind = image::FitKind::letterbox) {
  return fitted_camera(camera, image::placement(photo_height, photo_width, height, width, kind), height,
                       width);
}
}  // namespace tapestry::raster

#pragma once
#include <tapestry/geometry/camera.hpp>

namespace tapestry::raster {
/// Rays through points of a picture, with z = 1; coordinates in pixels from the picture's corner.
struct PixelRays {
  std::array<double, 2> step;   ///< change of the ray's x and y per pixel
  std::array<double, 2> first;  ///< the ray's x and y at the corner

  PixelRays(const geometry::Camera& camera, std::size_t height, std::size_t width)
      : step{2 * camera.tan_half_fov_x / static_cast<double>(width),
             2 * camera.tan_half_fov_y / static_cast<double>(height)},
        first{-camera.tan_half_fov_x, -camera.tan_half_fov_y} {}

  [[nodiscard]] geometry::Vector3 at(double column, double row) const {
    return {first[0] + step[0] * column, first[1] + step[1] * row, 1};
  }

  /// {column, row} of a point of view space with z > 0.
  [[nodiscard]] std::array<double, 2> picture_point(const geometry::Vector3& point_view) const {
    return {(point_view[0] / point_view[2] - first[0]) / step[0],
            (point_view[1] / point_view[2] - first[1]) / step[1]};
  }
};

/// Distance of two points of a picture.
[[nodiscard]] inline double distance(const std::array<double, 2>& a, const std::array<double, 2>& b) {
  const double across = b[0] - a[0], down = b[1] - a[1];
  return std::sqrt(across * across + down * down);
}

/// a·column + b·row + c.
struct Affine {
  double a = 0, b = 0, c = 0;
  [[nodiscard]] double at(double column, double row) const { return a * column + b * row + c; }
};
}  // namespace tapestry::raster

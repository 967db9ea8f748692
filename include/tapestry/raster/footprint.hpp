#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <tapestry/geometry/camera.hpp>
#include <tapestry/geometry/transform.hpp>
#include <tapestry/raster/texture_layout.hpp>

namespace tapestry::raster {

/// Derivatives of barycentric coordinates with respect to the picture's column and row, in pixels.
struct BarycentricSlope {
  std::array<double, 3> per_column;
  std::array<double, 3> per_row;
};

/// With b_k = r·c_k / r·C, c_k = q_{k+1} × q_{k+2}, C = Σ c_k and the ray r = (rx, ry, 1),
///   ∂b_k/∂column = ∂rx/∂column · (c_k − b_k·C)_x / r·C,
/// and for rows the same with y. All zero for a face that is seen edge-on.
///
/// \param corners_view  q₀, q₁, q₂
/// \param barycentric   b, perspective-correct
[[nodiscard]] inline BarycentricSlope barycentric_slope(const std::array<geometry::Vector3, 3>& corners_view,
                                                        const std::array<double, 3>& barycentric,
                                                        const geometry::Camera& camera, double height,
                                                        double width) {
  geometry::Vector3 point{}, total{};
  std::array<geometry::Vector3, 3> c{};
  for (std::size_t k = 0; k < 3; ++k) {
    c[k] = geometry::cross(corners_view[(k + 1) % 3], corners_view[(k + 2) % 3]);
    total = geometry::add(total, c[k]);
    point = geometry::add(point, geometry::scale(corners_view[k], barycentric[k]));
  }
  const double scale = point[2] / geometry::dot(point, total);  // 1 / r·C with r = point / point_z
  BarycentricSlope slope{};
  if (!std::isfinite(scale)) return slope;
  for (std::size_t k = 0; k < 3; ++k) {
    slope.per_column[k] = 2 * camera.tan_half_fov_x / width * scale * (c[k][0] - barycentric[k] * total[0]);
    slope.per_row[k] = 2 * camera.tan_half_fov_y / height * scale * (c[k][1] - barycentric[k] * total[1]);
  }
  return slope;
}

/// Width of a pixel's footprint in an atlas, in texels: the longer of the two vectors that a step of a column
/// and of a row makes there (the rule of OpenGL).
///
/// \param corner_uvs  uv of the face's corners
[[nodiscard]] inline double footprint_texels(const BarycentricSlope& slope,
                                             const std::array<std::array<double, 2>, 3>& corner_uvs,
                                             const TextureLayout& layout) {
  const auto width_of = [&](const std::array<double, 3>& b) {
    double u = 0, v = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      u += b[k] * corner_uvs[k][0];
      v += b[k] * corner_uvs[k][1];
    }
    return std::hypot(u * static_cast<double>(layout.width) / layout.u_extent,
                      v * static_cast<double>(layout.height));
  };
  return std::max(width_of(slope.per_column), width_of(slope.per_row));
}

}  // namespace tapestry::raster

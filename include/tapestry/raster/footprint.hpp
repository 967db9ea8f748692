#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <tapestry/geometry/camera.hpp>
#include <tapestry/geometry/transform.hpp>
#include <tapestry/raster/texture_layout.hpp>
#include <utility>

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

/// Where a pixel lies in an atlas, to first order: the ellipse that its circle becomes there.
struct Footprint {
  double length = 0;                  ///< of the longer axis, texels
  double width = 0;                   ///< of the shorter one
  std::array<double, 2> along{0, 0};  ///< the longer axis, from end to end, in units of uv
};

/// The footprint of a pixel: the singular values of the map from steps in the picture to steps in the atlas,
/// and the direction in the atlas of the greater one.
///
/// \param corner_uvs  uv of the face's corners
[[nodiscard]] inline Footprint footprint_of(const BarycentricSlope& slope,
                                            const std::array<std::array<double, 2>, 3>& corner_uvs,
                                            const TextureLayout& layout) {
  const std::array<double, 2> texels_per_uv{static_cast<double>(layout.width) / layout.u_extent,
                                            static_cast<double>(layout.height)};
  const auto step = [&](const std::array<double, 3>& b) {
    std::array<double, 2> texels{0, 0};
    for (std::size_t k = 0; k < 3; ++k)
      for (std::size_t axis = 0; axis < 2; ++axis) texels[axis] += b[k] * corner_uvs[k][axis];
    return std::array<double, 2>{texels[0] * texels_per_uv[0], texels[1] * texels_per_uv[1]};
  };
  const auto [a, b] = step(slope.per_column);
  const auto [c, d] = step(slope.per_row);
  // J Jᵀ = [p r; r q]: half the sum of its eigenvalues and half their difference.
  const double p = a * a + c * c, q = b * b + d * d, r = a * b + c * d;
  const double mean = (p + q) / 2, half = (p - q) / 2, spread = std::sqrt(half * half + r * r);
  Footprint footprint;
  footprint.length = std::sqrt(mean + spread);
  if (!(footprint.length > 0 && std::isfinite(footprint.length))) return footprint;
  footprint.width = std::abs(a * d - b * c) / footprint.length;
  // The eigenvector of the greater, by the row of J Jᵀ − (mean − spread) that does not cancel.
  double x = spread + std::abs(half), y = r;
  if (half < 0) std::swap(x, y);
  const double norm = std::sqrt(x * x + y * y);
  if (norm > 0) {
    x *= footprint.length / norm;
    y *= footprint.length / norm;
  } else {
    x = footprint.length;  // a circle: any direction
  }
  footprint.along = {x / texels_per_uv[0], y / texels_per_uv[1]};
  return footprint;
}

}  // namespace tapestry::raster

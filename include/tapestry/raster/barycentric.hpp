#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <tapestry/geometry/camera.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/geometry/transform.hpp>
#include <vector>

namespace tapestry::raster {

/// Perspective-correct barycentric coordinates of the points that samples of a view show.
///
/// The ray r = (rx, ry, 1) through a sample meets the plane of the corners q₀, q₁, q₂ (view space) at
///   Σ b_k·q_k   with   b_k = r·(q_{k+1} × q_{k+2}) / Σ_j r·(q_{j+1} × q_{j+2}).
/// No division by a corner's depth is involved, so faces through the eye's plane need no clipping here.
/// Coordinates outside [0, 1], which snapping to 1/256 of a sample can cause at an edge, are clamped and
/// the three made to sum to 1 again; an edge-on face gives its centroid.
class Barycentric {
 public:
  Barycentric(const geometry::Camera& camera, std::size_t sample_rows, std::size_t sample_columns)
      : step_{2 * camera.tan_half_fov_x / static_cast<double>(sample_columns),
              2 * camera.tan_half_fov_y / static_cast<double>(sample_rows)},
        first_{step_[0] / 2 - camera.tan_half_fov_x, step_[1] / 2 - camera.tan_half_fov_y} {}

  /// Sets the face that at() is about, of always the same mesh; corners in view space.
  void select(const geometry::Mesh& mesh, const std::vector<geometry::Vector3>& positions_view,
              std::int32_t face) {
    if (face == face_) return;
    face_ = face;
    std::array<geometry::Vector3, 3> corners;
    for (std::size_t k = 0; k < 3; ++k) {
      corners[k] = positions_view[static_cast<std::size_t>(mesh.faces[static_cast<std::size_t>(face)][k])];
    }
    for (std::size_t k = 0; k < 3; ++k)
      cross_[k] = geometry::cross(corners[(k + 1) % 3], corners[(k + 2) % 3]);
  }

  /// b at the centre of a sample, or, between whole numbers, at a point between centres.
  [[nodiscard]] std::array<double, 3> at(double row, double column) const {
    const geometry::Vector3 ray{first_[0] + step_[0] * column, first_[1] + step_[1] * row, 1};
    std::array<double, 3> weight{geometry::dot(ray, cross_[0]), geometry::dot(ray, cross_[1]),
                                 geometry::dot(ray, cross_[2])};
    const double sum = weight[0] + weight[1] + weight[2];
    double total = 0;
    for (double& value : weight) {
      value = std::max(sum < 0 ? -value : value, 0.0);
      total += value;
    }
    if (!(total <= 1e6 * std::abs(sum)) || total == 0) return {1.0 / 3, 1.0 / 3, 1.0 / 3};
    for (double& value : weight) value *= 1 / total;
    return weight;
  }

 private:
  std::array<double, 2> step_;
  std::array<double, 2> first_;
  std::array<geometry::Vector3, 3> cross_{};
  std::int32_t face_ = -1;
};

}  // namespace tapestry::raster

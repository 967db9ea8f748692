#pragma once
#include <limits>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/raster/detail/pixel_rays.hpp>

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

  /// Sets the face for at(), always of the same mesh; corners in view space.
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

/// A face as functions of the picture: with the ray r = Σ w_k·q_k, w_k ≥ 0 on the face, Σ w_k = 1/z there,
/// and w_k·z are the barycentric coordinates.
struct FaceWeights {
  std::array<Affine, 3> w{};

  /// Sets the weights; returns false, with all weights 0, if they are not finite.
  /// \param corners  in view space
  [[nodiscard]] bool set(const PixelRays& rays, const std::array<geometry::Vector3, 3>& corners) {
    const double inverse = 1 / geometry::dot(corners[0], geometry::cross(corners[1], corners[2]));
    bool is_finite = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const geometry::Vector3 c = geometry::cross(corners[(k + 1) % 3], corners[(k + 2) % 3]);
      w[k] = {c[0] * inverse * rays.step[0], c[1] * inverse * rays.step[1],
              (c[2] + c[0] * rays.first[0] + c[1] * rays.first[1]) * inverse};
      is_finite = is_finite && geometry::is_finite({w[k].a, w[k].b, w[k].c});
    }
    if (!is_finite) w = {};
    return is_finite;
  }

  /// 1/z of the face's plane.
  [[nodiscard]] Affine inverse_depth() const {
    return {w[0].a + w[1].a + w[2].a, w[0].b + w[1].b + w[2].b, w[0].c + w[1].c + w[2].c};
  }

  /// 1/z where the ray meets the face, if it lies between two limits, else 0.
  [[nodiscard]] double hit(double column, double row, const std::array<double, 2>& limits) const {
    return hit({w[0].at(column, row), w[1].at(column, row), w[2].at(column, row)}, limits);
  }

  /// The same, from the weights there.
  [[nodiscard]] static double hit(const std::array<double, 3>& at, const std::array<double, 2>& limits) {
    if (!(at[0] >= 0 && at[1] >= 0 && at[2] >= 0)) return 0;
    const double inverse_depth = at[0] + at[1] + at[2];
    return inverse_depth >= limits[0] && inverse_depth <= limits[1] ? inverse_depth : 0;
  }

  /// Length over which the face, from a point that it hides, keeps hiding a line.
  /// \param way            of the line, of unit length
  /// \param inverse_depth  1/z of the line
  [[nodiscard]] double hidden_length(double column, double row, const std::array<double, 2>& way,
                                     const Affine& inverse_depth, const std::array<double, 2>& limits) const {
    const Affine own = this->inverse_depth();
    double length = std::numeric_limits<double>::infinity();
    const auto keep = [&](double a, double b, double value) {  // while value + (a, b)·way·length ≥ 0
      const double slope = a * way[0] + b * way[1];
      if (slope < 0) length = std::min(length, -value / slope);
    };
    for (const Affine& part : w) keep(part.a, part.b, part.at(column, row));
    const double nearness = own.at(column, row), factor = 1 + 1e-9;
    keep(own.a - factor * inverse_depth.a, own.b - factor * inverse_depth.b,
         nearness - factor * inverse_depth.at(column, row));
    keep(own.a, own.b, nearness - limits[0]);
    keep(-own.a, -own.b, limits[1] - nearness);
    return length;
  }

  /// Barycentric coordinates at a point, moved to the face's rim if the point lies beside the face.
  [[nodiscard]] std::array<double, 3> barycentric(double column, double row) const {
    std::array<double, 3> b{};
    double sum = 0;
    for (std::size_t k = 0; k < 3; ++k) {
      b[k] = std::max(w[k].at(column, row), 0.0);
      sum += b[k];
    }
    if (!(sum > 0)) return {1.0 / 3, 1.0 / 3, 1.0 / 3};
    for (double& value : b) value /= sum;
    return b;
  }
};
}  // namespace tapestry::raster

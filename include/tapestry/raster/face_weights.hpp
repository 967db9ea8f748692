#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <limits>
#include <tapestry/geometry/transform.hpp>
#include <tapestry/raster/pixel_rays.hpp>

namespace tapestry::raster {

/// A face as functions of the picture: with the ray r = Σ w_k·q_k, w_k ≥ 0 on the face, Σ w_k = 1/z there,
/// and w_k·z are the barycentric coordinates.
struct FaceWeights {
  std::array<Affine, 3> w{};

  /// False, and all 0, if they are not finite.
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

  /// The same, of the weights there.
  [[nodiscard]] static double hit(const std::array<double, 3>& at, const std::array<double, 2>& limits) {
    if (!(at[0] >= 0 && at[1] >= 0 && at[2] >= 0)) return 0;
    const double inverse_depth = at[0] + at[1] + at[2];
    return inverse_depth >= limits[0] && inverse_depth <= limits[1] ? inverse_depth : 0;
  }

  /// How far from a point that the face hides it goes on to hide a line.
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

  /// Barycentric coordinates at a point, brought to the face's rim where the point lies beside it.
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

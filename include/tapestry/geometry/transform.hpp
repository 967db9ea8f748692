#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <vector>

namespace tapestry::geometry {
/// A point, direction or normal; which space it lives in is in the variable's name.
using Vector3 = std::array<double, 3>;

/// Row-major 3×3 matrix.
using Matrix3 = std::array<Vector3, 3>;

[[nodiscard]] constexpr Vector3 add(const Vector3& a, const Vector3& b) {
  return {a[0] + b[0], a[1] + b[1], a[2] + b[2]};
}

[[nodiscard]] constexpr Vector3 subtract(const Vector3& a, const Vector3& b) {
  return {a[0] - b[0], a[1] - b[1], a[2] - b[2]};
}

[[nodiscard]] constexpr Vector3 scale(const Vector3& a, double factor) {
  return {a[0] * factor, a[1] * factor, a[2] * factor};
}

[[nodiscard]] constexpr double dot(const Vector3& a, const Vector3& b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

[[nodiscard]] constexpr Vector3 cross(const Vector3& a, const Vector3& b) {
  return {a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]};
}

[[nodiscard]] inline double length(const Vector3& a) { return std::sqrt(dot(a, a)); }

/// a / |a|; a itself when it has no length.
[[nodiscard]] inline Vector3 normalised(const Vector3& a) {
  const double size = length(a);
  return size > 0 ? scale(a, 1 / size) : a;
}

[[nodiscard]] inline bool is_finite(const Vector3& a) {
  return std::isfinite(a[0]) && std::isfinite(a[1]) && std::isfinite(a[2]);
}

/// M·a
[[nodiscard]] constexpr Vector3 multiply(const Matrix3& matrix, const Vector3& a) {
  return {dot(matrix[0], a), dot(matrix[1], a), dot(matrix[2], a)};
}

/// Mᵀ·a
[[nodiscard]] constexpr Vector3 multiply_transposed(const Matrix3& matrix, const Vector3& a) {
  return {matrix[0][0] * a[0] + matrix[1][0] * a[1] + matrix[2][0] * a[2],
          matrix[0][1] * a[0] + matrix[1][1] * a[1] + matrix[2][1] * a[2],
          matrix[0][2] * a[0] + matrix[1][2] * a[1] + matrix[2][2] * a[2]};
}

/// Whether M is orthonormal, a rotation or a reflection: no entry of M·Mᵀ − I exceeds `tolerance`. NaN is
/// not.
[[nodiscard]] inline bool is_orthonormal(const Matrix3& matrix, double tolerance = 1e-6) {
  for (std::size_t i = 0; i < 3; ++i) {
    for (std::size_t j = 0; j < 3; ++j)
      if (!(std::abs(dot(matrix[i], matrix[j]) - (i == j ? 1 : 0)) <= tolerance)) return false;
  }
  return true;
}

/// The smallest box along the axes around some points.
struct Bounds {
  Vector3 low{}, high{};

  [[nodiscard]] Vector3 middle() const { return scale(add(low, high), 0.5); }
  /// Half the longest side.
  [[nodiscard]] double half_length() const {
    const Vector3 extent = subtract(high, low);
    return std::max({extent[0], extent[1], extent[2]}) / 2;
  }
};

/// Points that are not finite do not count; without any other the box is the origin.
[[nodiscard]] inline Bounds bounds_of(const std::vector<Vector3>& points) {
  Bounds bounds;
  bool any = false;
  for (const Vector3& point : points) {
    if (!is_finite(point)) continue;
    for (std::size_t axis = 0; axis < 3; ++axis) {
      bounds.low[axis] = any ? std::min(bounds.low[axis], point[axis]) : point[axis];
      bounds.high[axis] = any ? std::max(bounds.high[axis], point[axis]) : point[axis];
    }
    any = true;
  }
  return bounds;
}
}  // namespace tapestry::geometry

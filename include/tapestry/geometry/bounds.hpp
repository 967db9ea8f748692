#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <tapestry/geometry/transform.hpp>
#include <vector>

namespace tapestry::geometry {

/// The smallest box along the axes around some points.
struct Bounds {
  Vector3 low{}, high{};

  [[nodiscard]] Vector3 middle() const { return scale(add(low, high), 0.5); }
  /// Of the longest side.
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

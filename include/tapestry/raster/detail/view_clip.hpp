#pragma once
#include <tapestry/geometry/camera.hpp>

namespace tapestry::raster {
/// Clipping in view space against near, far and a guard band around the picture.
///
/// All planes pass through the eye or face along z, so they are tested before any division by z; a
/// triangle that crosses z = 0 is cut like any other. The guard band reaches 2¹⁷ samples from the
/// picture's corner, within which coordinates in 1/256 of a sample fit 32 bits and their products 64.
class ViewClip {
 public:
  static constexpr unsigned invisible = 0x3F;   ///< outside near, far or one side of the picture
  static constexpr unsigned needs_cut = 0xF03;  ///< outside near, far or one side of the guard band
  static constexpr double guard_samples = 131072;

  /// Three corners, and at most one more for each of the six planes.
  struct Polygon {
    std::array<geometry::Vector3, 9> points;
    std::size_t size = 0;
  };

  ViewClip(const geometry::Camera& camera, std::size_t sample_rows, std::size_t sample_columns)
      : near_(camera.near),
        far_(camera.far),
        picture_{camera.tan_half_fov_x, camera.tan_half_fov_y},
        guard_{camera.tan_half_fov_x * (2 * guard_samples / static_cast<double>(sample_columns) - 1),
               camera.tan_half_fov_y * (2 * guard_samples / static_cast<double>(sample_rows) - 1)} {}

  /// One bit for each plane that the point is outside of: near, far, the picture's sides, then from bit
  /// 8 the guard band's sides.
  [[nodiscard]] unsigned outside(const geometry::Vector3& point) const {
    unsigned bits = (point[2] < near_ ? 1U : 0U) | (point[2] > far_ ? 2U : 0U);
    for (std::size_t axis = 0; axis < 2; ++axis) {
      const unsigned shift = 2 * static_cast<unsigned>(axis);
      const double edge = picture_[axis] * point[2], guard = guard_[axis] * point[2];
      bits |= ((point[axis] < -edge ? 4U : 0U) | (point[axis] > edge ? 8U : 0U)) << shift;
      bits |= ((point[axis] < -guard ? 0x100U : 0U) | (point[axis] > guard ? 0x200U : 0U)) << shift;
    }
    return bits;
  }

  /// The part of a triangle inside near, far and the guard band; fewer than three points when nothing is.
  [[nodiscard]] Polygon cut(const std::array<geometry::Vector3, 3>& corners) const {
    Polygon polygon;
    for (const geometry::Vector3& corner : corners) polygon.points[polygon.size++] = corner;
    polygon = cut_by(polygon, {0, 0, 1}, -near_);
    polygon = cut_by(polygon, {0, 0, -1}, far_);
    polygon = cut_by(polygon, {1, 0, guard_[0]}, 0);
    polygon = cut_by(polygon, {-1, 0, guard_[0]}, 0);
    polygon = cut_by(polygon, {0, 1, guard_[1]}, 0);
    return cut_by(polygon, {0, -1, guard_[1]}, 0);
  }

 private:
  /// Keeps normal·q + offset ≥ 0 (Sutherland and Hodgman). A cut is always computed from the inner point to
  /// the outer one, so that two faces sharing an edge get the same point, to the bit.
  [[nodiscard]] static Polygon cut_by(const Polygon& polygon, const geometry::Vector3& normal,
                                      double offset) {
    Polygon kept;
    for (std::size_t i = 0; i < polygon.size; ++i) {
      const geometry::Vector3& from = polygon.points[i];
      const geometry::Vector3& to = polygon.points[(i + 1) % polygon.size];
      const double height_from = geometry::dot(normal, from) + offset;
      const double height_to = geometry::dot(normal, to) + offset;
      if (height_from >= 0) kept.points[kept.size++] = from;
      if ((height_from >= 0) == (height_to >= 0)) continue;
      kept.points[kept.size++] = height_from >= 0 ? crossing(from, height_from, to, height_to)
                                                  : crossing(to, height_to, from, height_from);
    }
    return kept;
  }

  [[nodiscard]] static geometry::Vector3 crossing(const geometry::Vector3& inner, double inner_height,
                                                  const geometry::Vector3& outer, double outer_height) {
    const double share = inner_height / (inner_height - outer_height);
    return geometry::add(inner, geometry::scale(geometry::subtract(outer, inner), share));
  }

  double near_;
  double far_;
  std::array<double, 2> picture_;
  std::array<double, 2> guard_;
};

namespace detail {
/// True if a position in view space is finite, and small enough for finite products of its coordinates.
inline bool usable(const geometry::Vector3& point) {
  return std::abs(point[0]) <= 1e100 && std::abs(point[1]) <= 1e100 && std::abs(point[2]) <= 1e100;
}
}  // namespace detail

/// Corners are snapped to multiples of 2^-subpixel_bits of a sample.
inline constexpr std::int32_t subpixel_bits = 8;
inline constexpr std::int32_t subpixel_steps = 1 << subpixel_bits;  ///< of a sample

/// A position on the grid of samples. Members other than `outside` are valid only where no plane of
/// ViewClip::needs_cut is crossed.
struct alignas(16) ScreenVertex {
  std::int32_t x;         ///< 1/256 of a sample's width, rounded to nearest
  std::int32_t y;         ///< 1/256 of a sample's height
  std::uint32_t outside;  ///< see ViewClip::outside(), or `unusable`
  float inverse_depth;    ///< 1/z
};

/// Bit of ScreenVertex::outside, alone: a coordinate is not finite, or beyond 1e100.
inline constexpr std::uint32_t unusable = 0x1000;

/// The map from positions of the world to a grid of samples.
struct Projection {
  std::array<std::array<double, 3>, 3> rotation;  ///< view_from_world
  std::array<double, 3> translation;
  double near, far;
  std::array<double, 2> picture;  ///< x/z and y/z of the picture's edges
  std::array<double, 2> guard;    ///< likewise of the guard band
  std::array<double, 2> samples;  ///< per unit of x/z, y/z
  std::array<double, 2> centre;   ///< sample coordinate of x/z = 0, y/z = 0

  Projection(const geometry::Camera& camera, std::size_t sample_rows, std::size_t sample_columns)
      : rotation(camera.rotation), translation(camera.translation), near(camera.near), far(camera.far) {
    for (const std::size_t axis : {std::size_t{0}, std::size_t{1}}) {
      const auto count = static_cast<double>(axis == 0 ? sample_columns : sample_rows);
      picture[axis] = axis == 0 ? camera.tan_half_fov_x : camera.tan_half_fov_y;
      guard[axis] = picture[axis] * (2 * ViewClip::guard_samples / count - 1);
      samples[axis] = count / (2 * picture[axis]);
      centre[axis] = count / 2;
    }
  }
};

/// The rays (rx, ry, 1) through the samples of a grid, {x, y}.
struct RayGrid {
  std::array<double, 2> step;   ///< from a sample to the next
  std::array<double, 2> first;  ///< of the first sample's centre

  RayGrid(const geometry::Camera& camera, std::size_t sample_rows, std::size_t sample_columns)
      : step{2 * camera.tan_half_fov_x / static_cast<double>(sample_columns),
             2 * camera.tan_half_fov_y / static_cast<double>(sample_rows)},
        first{step[0] / 2 - camera.tan_half_fov_x, step[1] / 2 - camera.tan_half_fov_y} {}
};
}  // namespace tapestry::raster

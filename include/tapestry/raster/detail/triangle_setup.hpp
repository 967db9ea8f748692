#pragma once
#include <limits>
#include <tapestry/raster/detail/raster_kernels.hpp>

namespace tapestry::raster {
/// Samples whose centres a triangle's box contains, clipped to the grid; empty when first > last.
struct SampleRange {
  std::int32_t first;
  std::int32_t last;
};

/// Samples along one axis whose centres may lie in a triangle with these coordinates.
[[nodiscard]] inline SampleRange sample_range(const std::array<std::int32_t, 3>& coordinate,
                                              std::size_t sample_count) {
  const std::int32_t low = std::min(std::min(coordinate[0], coordinate[1]), coordinate[2]);
  const std::int32_t high = std::max(std::max(coordinate[0], coordinate[1]), coordinate[2]);
  constexpr std::int32_t half = subpixel_steps / 2;
  return {std::max((low - half + subpixel_steps - 1) >> subpixel_bits, 0),
          std::min((high - half) >> subpixel_bits, static_cast<std::int32_t>(sample_count) - 1)};
}

/// The faces that are drawn: all, or only those whose corners run counter-clockwise as the camera sees them.
/// For a closed mesh seen from outside the picture is the same.
enum class FaceCulling { none, back };

namespace detail {
/// Turns a face that crosses near, far or the guard band into triangles. For faces without a cut see set_up()
/// in vertex_kernels.inl.
class CutSetup {
 public:
  static constexpr std::size_t most_triangles = 7;  ///< of a face after the cuts

  CutSetup(const geometry::Camera& camera, std::size_t sample_rows, std::size_t sample_columns,
           FaceCulling culling)
      : projection_(camera, sample_rows, sample_columns),
        rays_(camera, sample_rows, sample_columns),
        clip_(camera, sample_rows, sample_columns),
        rows_(sample_rows),
        columns_(sample_columns),
        culling_(culling) {}

  /// Adds the triangles of a face, and returns their number.
  /// \param corners  in view space
  std::size_t add(std::int32_t face, const std::array<geometry::Vector3, 3>& corners,
                  ScreenTriangle* triangles) const {
    const ViewClip::Polygon polygon = clip_.cut(corners);
    if (polygon.size < 3) return 0;
    double nearest = std::numeric_limits<double>::infinity(), farthest = 0;
    std::array<std::array<std::int32_t, 2>, 9> place;
    for (std::size_t i = 0; i < polygon.size; ++i) {
      nearest = std::min(nearest, polygon.points[i][2]);
      farthest = std::max(farthest, polygon.points[i][2]);
      place[i] = snapped(projection_, polygon.points[i]);
    }
    ScreenTriangle triangle;
    triangle.face = face;
    triangle.inverse_depth_min = static_cast<float>(1 / farthest);
    triangle.inverse_depth_max = static_cast<float>(1 / nearest);
    set_depth(corners, triangle);
    std::size_t count = 0;
    for (std::size_t i = 1; i + 1 < polygon.size; ++i) {
      triangle.x = {place[0][0], place[i][0], place[i + 1][0]};
      triangle.y = {place[0][1], place[i][1], place[i + 1][1]};
      const SampleRange columns = sample_range(triangle.x, columns_), rows = sample_range(triangle.y, rows_);
      if (columns.first > columns.last || rows.first > rows.last) continue;
      if (turn_clockwise(triangle)) triangles[count++] = triangle;
    }
    return count;
  }

 private:
  /// Makes the corners clockwise; returns false when the triangle has no area, or its visible side is not
  /// drawn.
  [[nodiscard]] bool turn_clockwise(ScreenTriangle& triangle) const {
    auto& x = triangle.x;
    auto& y = triangle.y;
    const std::int64_t doubled_area = (std::int64_t{x[1]} - x[0]) * (std::int64_t{y[2]} - y[0]) -
                                      (std::int64_t{y[1]} - y[0]) * (std::int64_t{x[2]} - x[0]);
    if (doubled_area == 0 || (doubled_area > 0 && culling_ == FaceCulling::back)) return false;
    const std::size_t second = doubled_area < 0 ? 2 : 1;  // rows grow downwards
    x = {x[0], x[second], x[3 - second]};
    y = {y[0], y[second], y[3 - second]};
    return true;
  }

  /// See set_depths() in vertex_kernels.inl.
  void set_depth(std::array<geometry::Vector3, 3> corners, ScreenTriangle& triangle) const {
    std::sort(corners.begin(), corners.end());
    const geometry::Vector3 normal = geometry::cross(geometry::subtract(corners[1], corners[0]),
                                                     geometry::subtract(corners[2], corners[0]));
    const double inverse_distance = 1 / geometry::dot(normal, corners[0]);
    const double per_x = normal[0] * inverse_distance, per_y = normal[1] * inverse_distance;
    const double per_column = per_x * rays_.step[0], per_row = per_y * rays_.step[1];
    const double first = normal[2] * inverse_distance + per_x * rays_.first[0] + per_y * rays_.first[1];
    if (std::abs(first) <= 1e37 && std::abs(per_column) <= 1e37 && std::abs(per_row) <= 1e37) {
      triangle.inverse_depth = {first, cut_short<16>(per_column), cut_short<16>(per_row)};
    } else {
      triangle.inverse_depth = {static_cast<double>(triangle.inverse_depth_max), 0, 0};
    }
    triangle.step = static_cast<float>(cut_short<33>(triangle.inverse_depth[1]));
  }

  template <int Bits>
  [[nodiscard]] static double cut_short(double value) {
    return std::bit_cast<double>(std::bit_cast<std::uint64_t>(value) & (~std::uint64_t{0} << Bits));
  }

  Projection projection_;
  RayGrid rays_;
  ViewClip clip_;
  std::size_t rows_;
  std::size_t columns_;
  FaceCulling culling_;
};
}  // namespace detail
}  // namespace tapestry::raster

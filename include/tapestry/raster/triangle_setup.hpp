#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <limits>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/geometry/camera.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/raster/view_clip.hpp>
#include <utility>
#include <vector>

namespace tapestry::raster {

/// A triangle ready for rasterising: sample coordinates in 1/256 of a sample's width, clockwise on the
/// screen, and 1/z as an affine function of the sample.
struct Triangle {
  std::array<std::int32_t, 3> x;
  std::array<std::int32_t, 3> y;
  std::int32_t face;
  float inverse_depth_min;  ///< 1/z is clamped to what the face's own points have: an edge-on plane is steep
  float inverse_depth_max;
  std::array<double, 3> inverse_depth;  ///< 1/z = [0] + [1]·column + [2]·row at the centre of a sample
};

/// Samples whose centres a triangle's box contains, cut to the grid; empty when first > last.
struct SampleRange {
  std::int32_t first;
  std::int32_t last;
};

inline constexpr std::int32_t subpixel_bits = 8;
inline constexpr std::int32_t subpixel_steps = 1 << subpixel_bits;

[[nodiscard]] inline SampleRange sample_range(const std::array<std::int32_t, 3>& coordinate,
                                              std::size_t sample_count) {
  const auto [low, high] = std::minmax({coordinate[0], coordinate[1], coordinate[2]});
  constexpr std::int32_t half = subpixel_steps / 2;
  return {std::max((low - half + subpixel_steps - 1) >> subpixel_bits, 0),
          std::min((high - half) >> subpixel_bits, static_cast<std::int32_t>(sample_count) - 1)};
}

/// The triangles of a mesh that may own samples of one view, in blocks of ascending face index.
struct TriangleBlocks {
  std::vector<std::vector<Triangle>> blocks;
  std::size_t non_finite_faces = 0;  ///< skipped, since a corner is not finite (or beyond 1e100)
};

namespace detail {

/// Turns faces of one view into triangles. Points are in view space.
class TriangleSetup {
 public:
  TriangleSetup(const geometry::Camera& camera, std::size_t sample_rows, std::size_t sample_columns)
      : clip_(camera, sample_rows, sample_columns), rows_(sample_rows), columns_(sample_columns) {
    for (const std::size_t axis : {std::size_t{0}, std::size_t{1}}) {
      const double tangent = axis == 0 ? camera.tan_half_fov_x : camera.tan_half_fov_y;
      const double count = static_cast<double>(axis == 0 ? columns_ : rows_);
      ray_step_[axis] = 2 * tangent / count;
      ray_first_[axis] = ray_step_[axis] / 2 - tangent;
      pixels_[axis] = count / (2 * tangent);
      centre_[axis] = count / 2;
    }
  }

  /// Appends the triangles of a face, none, one or, when clipped, several.
  void add(std::int32_t face, const std::array<geometry::Vector3, 3>& corners,
           std::vector<Triangle>& triangles) const {
    const std::array<unsigned, 3> outside{clip_.outside(corners[0]), clip_.outside(corners[1]),
                                          clip_.outside(corners[2])};
    if ((outside[0] & outside[1] & outside[2] & ViewClip::invisible) != 0) return;
    Triangle triangle;
    triangle.face = face;
    set_depth(corners, triangle);
    if (((outside[0] | outside[1] | outside[2]) & ViewClip::needs_cut) == 0) {
      add_snapped(corners, triangle, triangles);
      return;
    }
    const ViewClip::Polygon polygon = clip_.cut(corners);
    if (polygon.size < 3) return;
    double nearest = std::numeric_limits<double>::infinity(), farthest = 0;
    for (std::size_t i = 0; i < polygon.size; ++i) {
      nearest = std::min(nearest, polygon.points[i][2]);
      farthest = std::max(farthest, polygon.points[i][2]);
    }
    triangle.inverse_depth_min = static_cast<float>(1 / farthest);
    triangle.inverse_depth_max = static_cast<float>(1 / nearest);
    for (std::size_t i = 1; i + 1 < polygon.size; ++i) {
      add_snapped({polygon.points[0], polygon.points[i], polygon.points[i + 1]}, triangle, triangles);
    }
  }

 private:
  /// Nearest multiple of 1/256 of a sample, halves upwards.
  [[nodiscard]] std::int32_t snapped(const geometry::Vector3& point, std::size_t axis) const {
    constexpr double offset = 1 << 30;  // keeps the number positive, so that truncation is a floor
    const double coordinate = point[axis] / point[2] * pixels_[axis] + centre_[axis];
    return static_cast<std::int32_t>(static_cast<std::int64_t>(coordinate * subpixel_steps + (offset + 0.5)) -
                                     (std::int64_t{1} << 30));
  }

  void add_snapped(const std::array<geometry::Vector3, 3>& corners, Triangle triangle,
                   std::vector<Triangle>& triangles) const {
    for (std::size_t k = 0; k < 3; ++k) {
      triangle.x[k] = snapped(corners[k], 0);
      triangle.y[k] = snapped(corners[k], 1);
    }
    const SampleRange columns = sample_range(triangle.x, columns_);
    const SampleRange rows = sample_range(triangle.y, rows_);
    if (columns.first > columns.last || rows.first > rows.last) return;
    const auto& [x, y] = std::pair{triangle.x, triangle.y};
    const std::int64_t doubled_area = (std::int64_t{x[1]} - x[0]) * (std::int64_t{y[2]} - y[0]) -
                                      (std::int64_t{y[1]} - y[0]) * (std::int64_t{x[2]} - x[0]);
    if (doubled_area == 0) return;
    if (doubled_area < 0) {
      std::swap(triangle.x[1], triangle.x[2]);
      std::swap(triangle.y[1], triangle.y[2]);
    }
    triangles.push_back(triangle);
  }

  /// The plane n·q = n·q₀ through the corners meets the ray z·(rx, ry, 1) at 1/z = n·(rx, ry, 1) / n·q₀.
  /// Corners are taken in an order that depends on their positions only, so that faces with the same
  /// corners get the same bits and tie, whatever their winding.
  void set_depth(std::array<geometry::Vector3, 3> corners, Triangle& triangle) const {
    std::sort(corners.begin(), corners.end());
    const geometry::Vector3 normal = geometry::cross(geometry::subtract(corners[1], corners[0]),
                                                     geometry::subtract(corners[2], corners[0]));
    const double distance = geometry::dot(normal, corners[0]);
    const auto [nearest, farthest] = std::minmax({corners[0][2], corners[1][2], corners[2][2]});
    triangle.inverse_depth_min = static_cast<float>(1 / farthest);
    triangle.inverse_depth_max = static_cast<float>(1 / nearest);
    const double per_x = normal[0] / distance, per_y = normal[1] / distance;
    triangle.inverse_depth = {normal[2] / distance + per_x * ray_first_[0] + per_y * ray_first_[1],
                              per_x * ray_step_[0], per_y * ray_step_[1]};
    if (!geometry::is_finite(triangle.inverse_depth)) triangle.inverse_depth = {1 / nearest, 0, 0};
  }

  ViewClip clip_;
  std::size_t rows_;
  std::size_t columns_;
  std::array<double, 2> ray_step_;   // change of rx, ry from a sample to the next
  std::array<double, 2> ray_first_;  // rx, ry of the first sample's centre
  std::array<double, 2> pixels_;     // samples per unit of x/z, y/z
  std::array<double, 2> centre_;     // sample coordinate of x/z = 0, y/z = 0
};

inline bool usable(const geometry::Vector3& point) {
  return std::abs(point[0]) <= 1e100 && std::abs(point[1]) <= 1e100 && std::abs(point[2]) <= 1e100;
}

}  // namespace detail

/// All positions of a mesh in view space; those that are not finite stay so.
[[nodiscard]] inline std::vector<geometry::Vector3> positions_in_view(const geometry::Mesh& mesh,
                                                                      const geometry::Camera& camera) {
  std::vector<geometry::Vector3> positions(mesh.positions.size());
  constexpr std::size_t block = 8192;
  parallel_for(block_count(positions.size(), block), [&](std::size_t index) {
    const auto [begin, end] = block_range(index, positions.size(), block);
    for (std::size_t i = begin; i < end; ++i) positions[i] = view_from_world(camera, mesh.positions[i]);
  });
  return positions;
}

/// Throws Error (mismatch) naming the face unless every corner of every face exists.
inline void require_corners(const char* operation, const geometry::Mesh& mesh) {
  for (std::size_t face = 0; face < mesh.faces.size(); ++face) {
    for (const std::int32_t corner : mesh.faces[face]) {
      if (corner < 0 || static_cast<std::size_t>(corner) >= mesh.positions.size()) {
        throw Error(ErrorKind::mismatch, std::string(operation) + ": face " + std::to_string(face) +
                                             " refers to position " + std::to_string(corner) + " of " +
                                             std::to_string(mesh.positions.size()));
      }
    }
  }
}

/// Clipped, snapped triangles of the faces that touch the view. Faces whose box lies between samples,
/// and faces without area after snapping, leave none.
[[nodiscard]] inline TriangleBlocks set_up_triangles(const geometry::Mesh& mesh,
                                                     const std::vector<geometry::Vector3>& positions_view,
                                                     const geometry::Camera& camera, std::size_t sample_rows,
                                                     std::size_t sample_columns) {
  constexpr std::size_t block = 1024;
  const detail::TriangleSetup setup(camera, sample_rows, sample_columns);
  TriangleBlocks result;
  result.blocks.resize(block_count(mesh.faces.size(), block));
  std::vector<std::size_t> non_finite(result.blocks.size(), 0);
  parallel_for(result.blocks.size(), [&](std::size_t index) {
    const auto [begin, end] = block_range(index, mesh.faces.size(), block);
    for (std::size_t face = begin; face < end; ++face) {
      std::array<geometry::Vector3, 3> corners;
      for (std::size_t k = 0; k < 3; ++k) {
        corners[k] = positions_view[static_cast<std::size_t>(mesh.faces[face][k])];
      }
      if (!detail::usable(corners[0]) || !detail::usable(corners[1]) || !detail::usable(corners[2])) {
        ++non_finite[index];
        continue;
      }
      setup.add(static_cast<std::int32_t>(face), corners, result.blocks[index]);
    }
  });
  for (const std::size_t count : non_finite) result.non_finite_faces += count;
  return result;
}

}  // namespace tapestry::raster

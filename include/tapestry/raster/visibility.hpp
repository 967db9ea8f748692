#pragma once
#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/raster/triangle_setup.hpp>
#include <vector>

namespace tapestry::raster {

/// Which face owns each sample of a picture. Samples form a regular grid, samples_per_axis² in each
/// pixel, each at the centre of its cell.
struct VisibilityBuffer {
  std::size_t height = 0;  ///< pixels
  std::size_t width = 0;   ///< pixels
  std::size_t samples_per_axis = 1;
  std::vector<std::int32_t> face;  ///< [height · samples_per_axis, width · samples_per_axis], −1 for none
  std::size_t non_finite_faces = 0;  ///< faces left out since a corner is not finite
};

namespace detail {

/// Greatest number of samples along an axis; with it all integers of the rasteriser fit.
inline constexpr std::size_t sample_limit = 32768;
inline constexpr std::size_t band_rows = 32;

/// Edge function of one side at the first sample of the range, in whole samples, and its steps.
/// A sample is inside where all three are ≥ 0. Doubled-area units are divided by 256, rounded down;
/// since steps are whole multiples of 256 this keeps every sign.
struct Edge {
  std::int64_t value;
  std::int64_t per_column;
  std::int64_t per_row;

  Edge(std::int64_t from_x, std::int64_t from_y, std::int64_t to_x, std::int64_t to_y, std::int64_t column,
       std::int64_t row)
      : per_column(from_y - to_y), per_row(to_x - from_x) {
    const std::int64_t x = column * subpixel_steps + subpixel_steps / 2 - from_x;
    const std::int64_t y = row * subpixel_steps + subpixel_steps / 2 - from_y;
    // Rows grow downwards and corners run clockwise: left sides go up, top sides go right.
    const bool is_top_left = per_column > 0 || (per_column == 0 && per_row > 0);
    value = (per_row * y + per_column * x - (is_top_left ? 0 : 1)) >> subpixel_bits;
  }

  /// Narrows [first, last] to the columns where value + column · per_column ≥ 0.
  static void narrow(std::int64_t value, std::int64_t per_column, std::int64_t& first, std::int64_t& last) {
    if (value < 0) {
      first = per_column <= 0 ? last + 1 : std::max(first, (-value + per_column - 1) / per_column);
    } else if (value + last * per_column < 0) {
      last = std::min(last, value / -per_column);
    }
  }
};

/// Depth test of a run of samples. The nearer face wins; on a tie the one drawn first, so with faces in
/// ascending order the lowest.
inline void draw_run(const Triangle& triangle, double inverse_depth, std::int64_t count, float* depth,
                     std::int32_t* face) {
  const double step = triangle.inverse_depth[1];
  const auto low = static_cast<double>(triangle.inverse_depth_min);
  const auto high = static_cast<double>(triangle.inverse_depth_max);
  for (std::int64_t i = 0; i < count; ++i) {
    const double unclamped = inverse_depth + static_cast<double>(i) * step;
    const auto value = static_cast<float>(std::min(std::max(unclamped, low), high));
    if (value > depth[i]) {
      depth[i] = value;
      face[i] = triangle.face;
    }
  }
}

/// Draws the part of a triangle within a band of sample rows; `depth` holds the band's 1/z.
inline void draw_triangle(const Triangle& triangle, SampleRange band, std::size_t sample_columns,
                          float* depth, std::int32_t* faces) {
  const SampleRange columns = sample_range(triangle.x, sample_columns);
  SampleRange rows = sample_range(triangle.y, static_cast<std::size_t>(band.last) + 1);
  rows.first = std::max(rows.first, band.first);
  const auto& x = triangle.x;
  const auto& y = triangle.y;
  std::array<Edge, 3> edges{Edge(x[0], y[0], x[1], y[1], columns.first, rows.first),
                            Edge(x[1], y[1], x[2], y[2], columns.first, rows.first),
                            Edge(x[2], y[2], x[0], y[0], columns.first, rows.first)};
  for (std::int32_t row = rows.first; row <= rows.last; ++row) {
    std::int64_t first = 0, last = columns.last - columns.first;
    for (Edge& edge : edges) {
      Edge::narrow(edge.value, edge.per_column, first, last);
      edge.value += edge.per_row;
    }
    if (first > last) continue;
    const std::int64_t column = columns.first + first;
    const double inverse_depth = triangle.inverse_depth[0] +
                                 triangle.inverse_depth[1] * static_cast<double>(column) +
                                 triangle.inverse_depth[2] * static_cast<double>(row);
    const auto offset = static_cast<std::size_t>(row) * sample_columns + static_cast<std::size_t>(column);
    const auto band_offset = offset - static_cast<std::size_t>(band.first) * sample_columns;
    draw_run(triangle, inverse_depth, last - first + 1, depth + band_offset, faces + offset);
  }
}

/// For each band of rows, the triangles that touch it, in face order (a counting sort).
struct Bins {
  std::vector<std::size_t> begin;
  std::vector<const Triangle*> triangles;

  Bins(const std::vector<std::vector<Triangle>>& blocks, std::size_t sample_rows) {
    begin.assign(block_count(sample_rows, band_rows) + 1, 0);
    const auto for_each_band = [&](auto visit) {
      for (const auto& block : blocks) {
        for (const Triangle& triangle : block) {
          const SampleRange rows = sample_range(triangle.y, sample_rows);
          for (auto band = static_cast<std::size_t>(rows.first) / band_rows;
               band <= static_cast<std::size_t>(rows.last) / band_rows; ++band) {
            visit(band, triangle);
          }
        }
      }
    };
    for_each_band([&](std::size_t band, const Triangle&) { ++begin[band + 1]; });
    for (std::size_t band = 1; band < begin.size(); ++band) begin[band] += begin[band - 1];
    triangles.resize(begin.back());
    std::vector<std::size_t> next(begin.begin(), begin.end() - 1);
    for_each_band([&](std::size_t band, const Triangle& triangle) { triangles[next[band]++] = &triangle; });
  }
};

inline void require_view(const char* operation, const geometry::Camera& camera, std::size_t height,
                         std::size_t width, std::size_t samples_per_axis) {
  const std::string name = operation;
  if (samples_per_axis != 1 && samples_per_axis != 2 && samples_per_axis != 4 && samples_per_axis != 8) {
    throw DomainError(name + ": samples_per_axis is " + std::to_string(samples_per_axis) +
                      ", expected 1, 2, 4 or 8");
  }
  const std::size_t limit = sample_limit / samples_per_axis;
  if (height == 0 || width == 0 || height > limit || width > limit) {
    throw DomainError(name + ": picture is [" + std::to_string(height) + ", " + std::to_string(width) +
                      "], expected 1 to " + std::to_string(limit) + " pixels an axis at " +
                      std::to_string(samples_per_axis) + " samples an axis");
  }
  bool finite = geometry::is_finite(camera.translation);
  for (const auto& row : camera.rotation) finite = finite && geometry::is_finite(row);
  if (!finite || !(camera.near > 0) || !(camera.far > camera.near) || !(camera.far <= 1e30) ||
      !(camera.tan_half_fov_x > 0 && camera.tan_half_fov_x <= 1e6) ||
      !(camera.tan_half_fov_y > 0 && camera.tan_half_fov_y <= 1e6)) {
    throw DomainError(name +
                      ": the camera needs a finite pose, 0 < near < far ≤ 1e30 and tangents in (0, 1e6]");
  }
}

}  // namespace detail

/// Finds the face that each sample of a picture shows.
///
/// Corners are snapped to 1/256 of a sample and tested with exact integers and the top-left rule, so a
/// sample on an edge between two faces belongs to exactly one. The nearest face wins, on a tie (in 1/z
/// rounded to float) the one with the lowest index. Both sides of a face are drawn. Faces through the
/// near plane are cut, faces with a corner that is not finite are left out and counted, faces without
/// area own nothing. The result is the same for any number of threads.
///
/// \throws DomainError for a picture or a camera outside the stated limits
/// \throws Error (mismatch) if a face refers to a missing position
[[nodiscard]] inline VisibilityBuffer visibility(const geometry::Mesh& mesh, const geometry::Camera& camera,
                                                 std::size_t height, std::size_t width,
                                                 std::size_t samples_per_axis = 2) {
  detail::require_view("visibility", camera, height, width, samples_per_axis);
  require_corners("visibility", mesh);
  const std::size_t rows = height * samples_per_axis, columns = width * samples_per_axis;
  const TriangleBlocks setup = set_up_triangles(mesh, positions_in_view(mesh, camera), camera, rows, columns);
  const detail::Bins bins(setup.blocks, rows);
  VisibilityBuffer buffer{height, width, samples_per_axis, {}, setup.non_finite_faces};
  buffer.face.resize(rows * columns);
  parallel_for(bins.begin.size() - 1, [&](std::size_t index) {
    const auto [begin, end] = block_range(index, rows, detail::band_rows);
    std::fill(buffer.face.data() + begin * columns, buffer.face.data() + end * columns, -1);
    if (bins.begin[index] == bins.begin[index + 1]) return;
    std::vector<float> depth((end - begin) * columns, 0.0F);
    const SampleRange band{static_cast<std::int32_t>(begin), static_cast<std::int32_t>(end) - 1};
    for (std::size_t entry = bins.begin[index]; entry < bins.begin[index + 1]; ++entry) {
      detail::draw_triangle(*bins.triangles[entry], band, columns, depth.data(), buffer.face.data());
    }
  });
  return buffer;
}

/// Share of each pixel's samples whose face satisfies a predicate, [H, W] in [0, 1]. The predicate is
/// not asked about samples without a face.
template <std::predicate<std::int32_t> Predicate>
[[nodiscard]] Array<float, 2> coverage_of(const VisibilityBuffer& buffer, Predicate is_counted) {
  const std::size_t axis = buffer.samples_per_axis, columns = buffer.width * axis;
  auto coverage = zeros<float, 2>({buffer.height, buffer.width});
  const float share = 1.0F / static_cast<float>(axis * axis);
  for (std::size_t row = 0; row < buffer.height * axis; ++row) {
    float* const target = coverage.data() + row / axis * buffer.width;
    const std::int32_t* const faces = buffer.face.data() + row * columns;
    for (std::size_t column = 0; column < columns; ++column) {
      if (faces[column] >= 0 && is_counted(faces[column])) target[column / axis] += share;
    }
  }
  return coverage;
}

/// Share of each pixel's samples that show the mesh, [H, W] in [0, 1].
[[nodiscard]] inline Array<float, 2> coverage_of(const VisibilityBuffer& buffer) {
  return coverage_of(buffer, [](std::int32_t) { return true; });
}

}  // namespace tapestry::raster

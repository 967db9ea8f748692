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
#include <tapestry/raster/tiled_triangles.hpp>
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

/// Finds the face that each sample of a picture shows.
///
/// Corners are snapped to 1/256 of a sample and tested with exact integers and the top-left rule, so a
/// sample on an edge between two faces belongs to exactly one. The nearest face wins, on a tie (in 1/z
/// rounded to float) the one with the lowest index. Both sides of a face are drawn, unless back faces are
/// culled. Faces through the near plane are cut, faces with a corner that is not finite are left out and
/// counted, faces without area own nothing. The result is the same, to the bit, for any number of threads
/// and any instruction set.
///
/// \throws DomainError for a picture or a camera outside the stated limits
/// \throws Error (mismatch) if a face refers to a missing position
[[nodiscard]] inline VisibilityBuffer visibility(const geometry::Mesh& mesh, const geometry::Camera& camera,
                                                 std::size_t height, std::size_t width,
                                                 std::size_t samples_per_axis = 2,
                                                 FaceCulling culling = FaceCulling::none,
                                                 const RasterKernels& kernels = raster_kernels()) {
  detail::require_view("visibility", camera, height, width, samples_per_axis);
  const std::size_t rows = height * samples_per_axis, columns = width * samples_per_axis;
  const TiledTriangles triangles("visibility", mesh, camera, rows, columns, culling, kernels);
  VisibilityBuffer buffer{height, width, samples_per_axis, {}, triangles.non_finite_faces()};
  buffer.face.assign(rows * columns, -1);
  parallel_for(triangles.tile_rows() * triangles.tile_columns(), [&](std::size_t index) {
    const std::size_t row = index / triangles.tile_columns(), column = index % triangles.tile_columns();
    triangles.draw(row, column, buffer.face.data() + tile_height * row * columns + tile_width * column,
                   columns);
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

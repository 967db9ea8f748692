#pragma once
#include <tapestry/core/array.hpp>
#include <tapestry/raster/detail/triangle_setup.hpp>

namespace tapestry::raster {
/// The face of each sample of a picture. Samples form a regular grid, samples_per_axis² in each pixel, each
/// at the centre of its cell.
struct VisibilityBuffer {
  std::size_t height = 0;  ///< pixels
  std::size_t width = 0;   ///< pixels
  std::size_t samples_per_axis = 1;
  std::vector<std::int32_t> face;  ///< [height · samples_per_axis, width · samples_per_axis], −1 for none
  std::size_t non_finite_faces = 0;  ///< faces left out since a corner is not finite
};

namespace detail {
/// Greatest number of samples along an axis; with it all integers of the rasteriser fit. On a 32-bit
/// processor also the bytes of all samples.
inline constexpr std::size_t sample_limit = sizeof(std::size_t) > 4 ? 32768 : 16384;
void require_view(const char* operation, const geometry::Camera& camera, std::size_t height,
                  std::size_t width, std::size_t samples_per_axis);
}  // namespace detail

/// All positions of a mesh in view space; those that are not finite stay so.
[[nodiscard]] std::vector<geometry::Vector3> positions_in_view(const geometry::Mesh& mesh,
                                                               const geometry::Camera& camera);

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
[[nodiscard]] VisibilityBuffer visibility(const geometry::Mesh& mesh, const geometry::Camera& camera,
                                          std::size_t height, std::size_t width,
                                          std::size_t samples_per_axis = 2,
                                          FaceCulling culling = FaceCulling::none,
                                          const RasterKernels& kernels = raster_kernels());

/// Share of each pixel's samples whose face satisfies a predicate, [H, W] in [0, 1]. The predicate is not
/// called for samples without a face.
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

/// Median length in pixels of a mesh's edges in a picture, 0 if it has none; taken over at most 4,096 faces,
/// evenly chosen, with all corners in front of the camera and within the picture.
[[nodiscard]] double median_edge_px(const geometry::Mesh& mesh, const geometry::Camera& camera,
                                    std::size_t height, std::size_t width);

/// Samples along an axis of a pixel that make the median edge of a mesh at least four samples long:
/// 1, 2, 4 or 8. If none is enough, the most that the picture's size allows; 1 if no edge is seen.
/// On the car of the benchmark this keeps the error of the gradient of a face's colour between 1 and
/// 5 % at distances 1.5 to 20.
/// \throws DomainError, Error as visibility()
[[nodiscard]] std::size_t automatic_samples_per_axis(const geometry::Mesh& mesh,
                                                     const geometry::Camera& camera, std::size_t height,
                                                     std::size_t width);
}  // namespace tapestry::raster

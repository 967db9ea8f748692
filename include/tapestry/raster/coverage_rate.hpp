#pragma once
#include <cstddef>
#include <tapestry/core/compiled.hpp>
#include <tapestry/geometry/camera.hpp>
#include <tapestry/geometry/mesh.hpp>

namespace tapestry::raster {

/// Median length in pixels of the edges that a mesh has in a picture, 0 if it has none: of faces whose
/// corners are all in front of the camera and within the picture, at most 4,096 of them, evenly chosen.
[[nodiscard]] double median_edge_px(const geometry::Mesh& mesh, const geometry::Camera& camera,
                                    std::size_t height, std::size_t width);

/// Samples along an axis of a pixel with which the median edge of a mesh is at least four samples long: 1, 2,
/// 4 or 8, the most that the picture's size allows when none is enough, and 1 where no edge is seen. On the
/// car of the benchmark this keeps the error of the gradient of a face's colour between 1 and 5 % at
/// distances 1.5 to 20. \throws DomainError, Error as visibility()
[[nodiscard]] std::size_t automatic_samples_per_axis(const geometry::Mesh& mesh,
                                                     const geometry::Camera& camera, std::size_t height,
                                                     std::size_t width);

}  // namespace tapestry::raster

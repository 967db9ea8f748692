#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <tapestry/geometry/camera.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/raster/coverage_rate.hpp>
#include <tapestry/raster/pixel_rays.hpp>
#include <tapestry/raster/tiled_triangles.hpp>
#include <tapestry/raster/visibility.hpp>
#include <vector>

namespace tapestry::raster {

double median_edge_px(const geometry::Mesh& mesh, const geometry::Camera& camera, std::size_t height,
                      std::size_t width) {
  const PixelRays rays(camera, height, width);
  const ViewClip clip(camera, height, width);
  constexpr std::size_t most = 4096;
  const std::size_t step = std::max<std::size_t>(1, (mesh.faces.size() + most - 1) / most);
  std::vector<double> lengths;
  lengths.reserve(3 * most);
  for (std::size_t face = 0; face < mesh.faces.size(); face += step) {
    std::array<std::array<double, 2>, 3> point;
    bool is_inside = true;
    for (std::size_t k = 0; k < 3; ++k) {
      const auto corner = static_cast<std::size_t>(mesh.faces[face][k]);
      const geometry::Vector3 view = view_from_world(camera, mesh.positions[corner]);
      is_inside = is_inside && detail::usable(view) && clip.outside(view) == 0;
      point[k] = rays.picture_point(view);
    }
    for (std::size_t k = 0; is_inside && k < 3; ++k)
      lengths.push_back(std::hypot(point[k][0] - point[(k + 1) % 3][0], point[k][1] - point[(k + 1) % 3][1]));
  }
  if (lengths.empty()) return 0;
  const auto middle = lengths.begin() + static_cast<std::ptrdiff_t>(lengths.size() / 2);
  std::nth_element(lengths.begin(), middle, lengths.end());
  return *middle;
}

std::size_t automatic_samples_per_axis(const geometry::Mesh& mesh, const geometry::Camera& camera,
                                       std::size_t height, std::size_t width) {
  detail::require_view("automatic_samples_per_axis", camera, height, width, 1);
  require_corners("automatic_samples_per_axis", mesh);
  const double edge = median_edge_px(mesh, camera, height, width);
  std::size_t samples = 1;
  while (samples < 8 && edge > 0 && edge * static_cast<double>(samples) < 4 &&
         2 * samples * std::max(height, width) <= detail::sample_limit)
    samples *= 2;
  return samples;
}

}  // namespace tapestry::raster

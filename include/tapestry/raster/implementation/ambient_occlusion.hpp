#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/geometry/transform.hpp>
#include <tapestry/raster/ambient_occlusion.hpp>
#include <tapestry/raster/parallel_view.hpp>
#include <tapestry/raster/sky.hpp>
#include <vector>

namespace tapestry::raster {

double AmbientOcclusion::at(std::size_t face, std::size_t side, const std::array<double, 3>& b) const {
  const auto& corner = open[face][side];
  double sum = 0;
  for (std::size_t k = 0; k < 3; ++k) sum += b[k] * static_cast<double>(corner[k]);
  return sum;
}

namespace detail {

/// Share of a face's inside by which its corners are moved inwards, where what hides them is looked up.
inline constexpr double occlusion_inset = 0.25;

/// Open directions that a face sees, by their cosines, before it is divided by all.
struct OcclusionSums {
  std::array<double, 2> whole{0, 0};            ///< of each side
  std::array<std::array<double, 3>, 2> open{};  ///< of each side, at each corner
};

inline void add_direction(const geometry::Mesh& mesh, std::size_t face, const geometry::Vector3& direction,
                          const ParallelView& view, OcclusionSums& sums) {
  std::array<geometry::Vector3, 3> corner;
  for (std::size_t k = 0; k < 3; ++k)
    corner[k] = mesh.positions[static_cast<std::size_t>(mesh.faces[face][k])];
  const double cosine =
      geometry::dot(geometry::normalised(geometry::cross(geometry::subtract(corner[1], corner[0]),
                                                         geometry::subtract(corner[2], corner[0]))),
                    direction);
  if (cosine == 0 || !std::isfinite(cosine)) return;
  const std::size_t side = cosine > 0 ? 0 : 1;
  sums.whole[side] += std::abs(cosine);
  const auto middle =
      geometry::scale(geometry::add(geometry::add(corner[0], corner[1]), corner[2]), occlusion_inset / 3);
  for (std::size_t k = 0; k < 3; ++k)
    sums.open[side][k] +=
        std::abs(cosine) *
        view.visible_share(face, geometry::add(geometry::scale(corner[k], 1 - occlusion_inset), middle));
}

}  // namespace detail

AmbientOcclusion ambient_occlusion(const geometry::Mesh& mesh, std::size_t directions, std::size_t pixels) {
  if (directions == 0 || directions > 65536)
    throw DomainError("ambient_occlusion: directions is " + std::to_string(directions) +
                      ", expected 1 to 65536");
  std::vector<detail::OcclusionSums> sums(mesh.faces.size());
  constexpr std::size_t block = 1024;
  for (std::size_t index = 0; index < directions; ++index) {
    const geometry::Vector3 direction = spiral_direction(index, directions);
    const ParallelView view(mesh, direction, pixels);
    parallel_for(block_count(sums.size(), block), [&](std::size_t part) {
      const auto [begin, end] = block_range(part, sums.size(), block);
      for (std::size_t face = begin; face < end; ++face)
        detail::add_direction(mesh, face, direction, view, sums[face]);
    });
  }
  AmbientOcclusion result;
  result.open.resize(sums.size());
  for (std::size_t face = 0; face < sums.size(); ++face)
    for (std::size_t side = 0; side < 2; ++side) {
      const auto& open = sums[face].open[side];
      const double whole = sums[face].whole[side], mean = (open[0] + open[1] + open[2]) / 3;
      for (std::size_t k = 0; k < 3; ++k) {
        const double at_corner = (open[k] - detail::occlusion_inset * mean) / (1 - detail::occlusion_inset);
        result.open[face][side][k] =
            whole > 0 ? static_cast<float>(std::clamp(at_corner / whole, 0.0, 1.0)) : 1.0F;
      }
    }
  return result;
}

}  // namespace tapestry::raster

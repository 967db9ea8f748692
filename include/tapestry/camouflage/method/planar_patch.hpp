#pragma once
#include <algorithm>
#include <array>
#include <concepts>
#include <tapestry/camouflage/method/method.hpp>
#include <tapestry/raster/painted_mesh.hpp>

namespace tapestry::camouflage {
namespace detail {

inline bool is_inside(const std::array<double, 2>& place) {
  return std::min(place[0], place[1]) >= 0 && std::max(place[0], place[1]) <= 1;
}

}  // namespace detail

/// One square picture on roof, hood and doors, upright and readable on each, as large as the panel lets it
/// be; the rest of the car keeps its own colours. The picture has about as many pixels as its largest copy
/// has texels.
///
/// Source: the patches of Thys et al., "Fooling automated surveillance cameras" (CVPR workshops 2019),
/// section 3, pasted on a car as the camouflage papers compare with them. Faithful: one picture for all
/// places. Seen by a camera the panel's picture is its homography as far as the panel is flat. Simplified:
/// smoothness and printability are those of the objective.
///
/// \throws as panel_texels(); Error (mismatch) if no panel holds a square of texels
template <std::floating_point T>
[[nodiscard]] Method<T> planar_patch(const raster::PaintedMesh& car);

}  // namespace tapestry::camouflage

#pragma once
#include <array>
#include <concepts>
#include <cstdint>
#include <tapestry/camouflage/method/method.hpp>
#include <tapestry/core/random.hpp>
#include <tapestry/raster/painted_mesh.hpp>

namespace tapestry::camouflage {
namespace detail {

/// Noise between the points of a lattice, in [0, 1): smooth, and the same at the same place.
[[nodiscard]] double lattice_noise(const std::array<double, 3>& x, const Random& random);

}  // namespace detail

/// How far a colour of upc() may be from its picture.
inline constexpr double upc_bound = 35.0 / 255;

/// A set of patches, one for roof, hood and either side's doors, each texel for itself but within upc_bound
/// of a natural picture; the rest of the car keeps its own colours.
///
/// Source: Huang et al., "Universal Physical Camouflage Attacks on Object Detectors" (CVPR 2020),
/// sections 3.2 and 3.3: patterns on few regions, shared by all views, with a semantic constraint ‖pattern −
/// picture‖∞ ≤ ε. Faithful: regions, universality, and the bound. Simplified: four regions for eight; foliage
/// that we draw stands for a photograph; the bound holds by the parameter, see method_colours(), and not by a
/// projection after each step; there are no proposals of a first stage to attack, and the loss is the
/// objective's; pictures are transformed where the conditions of a run say so, in the paper at every step.
///
/// \throws as panel_texels()
template <std::floating_point T>
[[nodiscard]] Method<T> upc(const raster::PaintedMesh& car, std::uint64_t seed);

}  // namespace tapestry::camouflage

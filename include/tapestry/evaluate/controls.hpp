#pragma once
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tapestry/camouflage/paint.hpp>
#include <tapestry/camouflage/texture_parameter.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/random.hpp>
#include <tapestry/evaluate/matched_noise.hpp>
#include <tapestry/evaluate/shuffled_patches.hpp>
#include <tapestry/raster/painted_mesh.hpp>
#include <tapestry/raster/texture_charts.hpp>
#include <utility>
#include <vector>

namespace tapestry::evaluate {

/// A control: a texture that was not optimised. What hides the car from a detector must hide it better than
/// these do.
template <class T>
struct Control {
  std::string name;
  camouflage::Paint<T> paint{};
};

/// The control that an attack's effect is stated against.
inline constexpr const char* matched_noise_name = "matched noise";
inline constexpr const char* shuffled_patches_name = "shuffled";
/// Another camouflage, measured among the controls.
inline constexpr const char* other_run_name = "other run";

/// The controls that a camouflage is taken apart into: "matched noise" has its colours and its spectrum and
/// "shuffled" its parts, neither its design; see matched_noise() and shuffled_patches(). Texels that no view
/// has shown to the optimisation have kept their first colour, which moves about in their chart like others.
/// Where a camouflage covers parts of the car, so do they: each piece of a part that hangs together is a
/// chart of its own, and the rest stays the car's own. Copies of one picture are not copies in the noise. The
/// same for the same seed.
///
/// \throws ShapeError unless the paint is of the car's texels; as raster::texture_charts(), matched_noise()
template <std::floating_point T>
[[nodiscard]] std::vector<Control<T>> matched_controls(const raster::PaintedMesh& car,
                                                       const camouflage::Paint<T>& paint,
                                                       std::uint64_t seed) {
  const auto& [colours, painted] = paint;
  camouflage::require_sound("matched_controls", paint);
  require_shape("matched_controls", "colours", colours, {car.layout.texel_count(car.mesh), 3});
  const auto charts = raster::painted_charts(raster::texture_charts(car), painted);
  auto noise = matched_noise(colours, charts, Random(seed).fork(0x6D617463686564ULL));
  auto shuffled =
      shuffled_patches(colours, charts, patch_extents(car.layout), Random(seed).fork(0x73687566666C65ULL));
  return {{matched_noise_name, {std::move(noise), painted}},
          {shuffled_patches_name, {std::move(shuffled), painted}}};
}

/// Controls that know nothing of a camouflage: random noise and six solid colours all over the car; the same
/// for the same seed.
template <class T>
[[nodiscard]] std::vector<Control<T>> plain_controls(std::size_t texel_count, std::uint64_t seed) {
  Random random = Random(seed).fork(0x636F6E74726F6CULL);
  std::vector<Control<T>> controls;
  controls.push_back({"random", {camouflage::random_colours<T>(texel_count, random)}});
  const std::vector<std::pair<const char*, std::array<double, 3>>> solids{
      {"white", {0.95, 0.95, 0.95}}, {"grey", {0.5, 0.5, 0.5}},   {"black", {0.05, 0.05, 0.05}},
      {"red", {0.75, 0.08, 0.08}},   {"green", {0.1, 0.5, 0.15}}, {"blue", {0.1, 0.2, 0.7}}};
  for (const auto& [name, colour] : solids)
    controls.push_back({name, {camouflage::solid_colours<T>(texel_count, colour)}});
  return controls;
}

/// All controls of a camouflage: the matched ones, then the plain ones; parameters as for matched_controls().
template <std::floating_point T>
[[nodiscard]] std::vector<Control<T>> make_controls(const raster::PaintedMesh& car,
                                                    const camouflage::Paint<T>& paint, std::uint64_t seed) {
  auto controls = matched_controls(car, paint, seed);
  for (auto& control : plain_controls<T>(paint.colours.shape(0), seed))
    controls.push_back(std::move(control));
  return controls;
}

}  // namespace tapestry::evaluate

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
#include <tapestry/evaluate/controls.hpp>
#include <tapestry/evaluate/matched_noise.hpp>
#include <tapestry/evaluate/shuffled_patches.hpp>
#include <tapestry/raster/painted_mesh.hpp>
#include <tapestry/raster/texture_charts.hpp>
#include <utility>
#include <vector>

namespace tapestry::evaluate {

template <std::floating_point T>
std::vector<Control<T>> matched_controls(const raster::PaintedMesh& car, const camouflage::Paint<T>& paint,
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

template <class T>
std::vector<Control<T>> plain_controls(std::size_t texel_count, std::uint64_t seed) {
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

template <std::floating_point T>
std::vector<Control<T>> make_controls(const raster::PaintedMesh& car, const camouflage::Paint<T>& paint,
                                      std::uint64_t seed) {
  auto controls = matched_controls(car, paint, seed);
  for (auto& control : plain_controls<T>(paint.colours.shape(0), seed))
    controls.push_back(std::move(control));
  return controls;
}

template decltype(matched_controls<float>) matched_controls<float>;
template decltype(matched_controls<double>) matched_controls<double>;
template decltype(plain_controls<float>) plain_controls<float>;
template decltype(plain_controls<double>) plain_controls<double>;
template decltype(make_controls<float>) make_controls<float>;
template decltype(make_controls<double>) make_controls<double>;

}  // namespace tapestry::evaluate

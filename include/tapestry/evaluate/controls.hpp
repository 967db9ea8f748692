#pragma once
#include <array>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tapestry/camouflage/texture_parameter.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/core/random.hpp>
#include <utility>
#include <vector>

namespace tapestry::evaluate {

/// A control: a texture that was not optimised. What hides the car from a detector must hide it better than
/// these do.
template <class T>
struct Control {
  std::string name;
  Array<T, 2> colours;  ///< [texel, 3]
};

/// Random noise and five solid colours; the same for the same seed.
template <class T>
[[nodiscard]] std::vector<Control<T>> make_controls(std::size_t texel_count, std::uint64_t seed) {
  Random random = Random(seed).fork(0x636F6E74726F6CULL);
  std::vector<Control<T>> controls;
  controls.push_back({"random", camouflage::random_colours<T>(texel_count, random)});
  const std::vector<std::pair<const char*, std::array<double, 3>>> solids{{"white", {0.95, 0.95, 0.95}},
                                                                          {"black", {0.05, 0.05, 0.05}},
                                                                          {"red", {0.75, 0.08, 0.08}},
                                                                          {"green", {0.1, 0.5, 0.15}},
                                                                          {"blue", {0.1, 0.2, 0.7}}};
  for (const auto& [name, colour] : solids)
    controls.push_back({name, camouflage::solid_colours<T>(texel_count, colour)});
  return controls;
}

}  // namespace tapestry::evaluate

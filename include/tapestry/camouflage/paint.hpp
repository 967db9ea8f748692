#pragma once
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/image/transform/colour_change.hpp>
#include <utility>
#include <vector>

namespace tapestry::camouflage {

/// Colours for a car, and which of them are paint; the others are the car's own, which nobody prints.
template <class T>
struct Paint {
  Array<T, 2> colours{};                ///< [texel, 3], in [0, 1]
  std::vector<std::uint8_t> painted{};  ///< [texel], 1 for paint and 0 for the car's own; empty: all paint

  [[nodiscard]] bool operator==(const Paint&) const = default;
};

/// A car that is not painted.
template <class T>
[[nodiscard]] Paint<T> without_paint(Array<T, 2> colours) {
  std::vector<std::uint8_t> painted(colours.shape(0), 0);
  return {std::move(colours), std::move(painted)};
}

/// The colours as a printer makes those that are paint, [texel, 3].
/// \throws ShapeError unless `painted` is empty or has an entry a texel; else as image::transformed()
template <std::floating_point T>
[[nodiscard]] Array<T, 2> printed(const Paint<T>& paint, const image::ColourChange& print) {
  const auto& [colours, painted] = paint;
  auto result = image::transformed(colours, print);
  if (!painted.empty() && painted.size() != colours.shape(0))
    throw ShapeError("printed: " + std::to_string(painted.size()) + " texels are paint or not, expected " +
                     std::to_string(colours.shape(0)));
  for (std::size_t texel = 0; texel < painted.size(); ++texel)
    for (std::size_t c = 0; c < 3 && painted[texel] == 0; ++c) result(texel, c) = colours(texel, c);
  return result;
}

}  // namespace tapestry::camouflage

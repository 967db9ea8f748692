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

/// \throws ShapeError, naming the operation, unless `painted` is empty or has an entry a texel
template <class T>
void require_sound(const char* operation, const Paint<T>& paint) {
  if (!paint.painted.empty() && paint.painted.size() != paint.colours.shape(0))
    throw ShapeError(std::string(operation) + ": " + std::to_string(paint.painted.size()) +
                     " texels are paint or not, expected " + std::to_string(paint.colours.shape(0)));
}

/// The colours as a printer makes those that are paint, [texel, 3].
/// \throws ShapeError as require_sound(); else as image::transformed()
template <std::floating_point T>
[[nodiscard]] Array<T, 2> printed(const Paint<T>& paint, const image::ColourChange& print) {
  require_sound("printed", paint);
  const auto& [colours, painted] = paint;
  auto result = image::transformed(colours, print);
  for (std::size_t texel = 0; texel < painted.size(); ++texel)
    for (std::size_t c = 0; c < 3 && painted[texel] == 0; ++c) result(texel, c) = colours(texel, c);
  return result;
}

}  // namespace tapestry::camouflage

#pragma once
#include <concepts>
#include <cstdint>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/image/transform/colour_change.hpp>
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
[[nodiscard]] Paint<T> without_paint(Array<T, 2> colours);

/// \throws ShapeError, naming the operation, unless `painted` is empty or has an entry a texel
template <class T>
void require_sound(const char* operation, const Paint<T>& paint);

/// The colours as a printer makes those that are paint, [texel, 3].
/// \throws ShapeError as require_sound(); else as image::transformed()
template <std::floating_point T>
[[nodiscard]] Array<T, 2> printed(const Paint<T>& paint, const image::ColourChange& print);

}  // namespace tapestry::camouflage

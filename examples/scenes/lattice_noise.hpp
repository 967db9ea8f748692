#pragma once
#include <cmath>
#include <cstdint>

namespace tapestry::scenes {

namespace detail {
/// A well mixed value in [0, 1) for one corner of the integer lattice.
[[nodiscard]] inline float lattice_value(std::int32_t x, std::int32_t y, std::uint32_t seed) {
  std::uint32_t h = static_cast<std::uint32_t>(x) * 0x8DA6B343U ^
                    static_cast<std::uint32_t>(y) * 0xD8163841U ^ seed * 0x9E3779B9U;
  h = (h ^ (h >> 16U)) * 0x7FEB352DU;
  h = (h ^ (h >> 15U)) * 0x846CA68BU;
  return static_cast<float>((h ^ (h >> 16U)) >> 8U) * 0x1.0p-24F;
}

[[nodiscard]] inline float eased(double t) { return static_cast<float>(t * t * (3 - 2 * t)); }
}  // namespace detail

/// Smooth noise in the plane, in [0, 1], one lattice cell a unit of x and y.
[[nodiscard]] inline float lattice_noise(double x, double y, std::uint32_t seed) {
  const double floor_x = std::floor(x), floor_y = std::floor(y);
  const auto ix = static_cast<std::int32_t>(floor_x), iy = static_cast<std::int32_t>(floor_y);
  const float u = detail::eased(x - floor_x), v = detail::eased(y - floor_y);
  const auto along_x = [&](std::int32_t row) {
    const float left = detail::lattice_value(ix, row, seed);
    return left + (detail::lattice_value(ix + 1, row, seed) - left) * u;
  };
  const float low = along_x(iy);
  return low + (along_x(iy + 1) - low) * v;
}

}  // namespace tapestry::scenes

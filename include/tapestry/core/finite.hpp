#pragma once
#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstdint>
#include <limits>
#include <span>

namespace tapestry {
/// Whether a number is neither NaN nor infinite. Independent of floating-point flags: compilers may assume
/// under them that NaN does not exist. (libc++ 13 lacks std::bit_cast.)
[[nodiscard]] inline bool is_finite(float value) {
  return (__builtin_bit_cast(std::uint32_t, value) & 0x7F800000U) != 0x7F800000U;
}

/// Whether all are finite: only an exponent of all ones carries into the highest bit.
[[nodiscard]] inline bool are_finite(std::span<const float> values) {
  std::uint32_t carried = 0;
  for (const float value : values)
    carried |= (__builtin_bit_cast(std::uint32_t, value) & 0x7F800000U) + 0x00800000U;
  return carried >> 31U == 0;
}

/// √(x² + y²)
template <std::floating_point T>
[[nodiscard]] T hypot(T x, T y) {
  return std::hypot(x, y);
}

/// √(x² + y² + z²), finite where the length is. std::hypot of three has other bits in each standard library,
/// and overflows in some.
template <std::floating_point T>
[[nodiscard]] T hypot(T x, T y, T z) {
  x = std::abs(x), y = std::abs(y), z = std::abs(z);
  const T largest = std::max({x, y, z});
  if (!(largest > 0 && largest <= std::numeric_limits<T>::max())) return x + y + z;
  return largest * std::sqrt((x / largest) * (x / largest) + (y / largest) * (y / largest) +
                             (z / largest) * (z / largest));
}
}  // namespace tapestry

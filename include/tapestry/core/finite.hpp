#pragma once
#include <bit>
#include <cstdint>
#include <span>

namespace tapestry {

/// Whether a number is neither NaN nor infinite. Independent of floating-point flags: compilers may assume
/// under them that NaN does not exist.
[[nodiscard]] inline bool is_finite(float value) {
  return (std::bit_cast<std::uint32_t>(value) & 0x7F800000U) != 0x7F800000U;
}

/// Whether all are finite: only an exponent of all ones carries into the highest bit.
[[nodiscard]] inline bool are_finite(std::span<const float> values) {
  std::uint32_t carried = 0;
  for (const float value : values)
    carried |= (std::bit_cast<std::uint32_t>(value) & 0x7F800000U) + 0x00800000U;
  return carried >> 31U == 0;
}

}  // namespace tapestry

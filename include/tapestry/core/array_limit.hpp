#pragma once
#include <cstddef>
#include <limits>

namespace tapestry {
/// Most elements of an array: the bytes of more, up to 16 each, could not be counted. Whoever multiplies
/// extents that a file or a user states compares with it: 2⁶⁰ − 1, or 2²⁸ − 1 on a 32-bit processor.
inline constexpr std::size_t array_limit = std::numeric_limits<std::size_t>::max() >> 4U;
}  // namespace tapestry

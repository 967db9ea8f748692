#pragma once
#include <algorithm>
#include <bit>
#include <compare>
#include <cstddef>
#include <cstdint>

namespace tapestry::raster {

/// A face in a cell: in the low half its slot, in the high half its farness, the complement of the greatest
/// 1/z that it may have there, a float's bits, so that the nearest is the least.
struct CellEntry {
  std::uint64_t bits;

  [[nodiscard]] static CellEntry of(std::uint32_t farness, std::uint32_t slot) {
    return {std::uint64_t{farness} << 32U | slot};
  }
  [[nodiscard]] static std::uint32_t farness_of(double inverse_depth_max) {
    const float least = static_cast<float>(std::clamp(inverse_depth_max, 0.0, 3e38));
    return ~(std::bit_cast<std::uint32_t>(least) + 1);  // of the next float, which is not less
  }

  [[nodiscard]] std::size_t slot() const { return bits & 0xFFFFFFFFU; }
  [[nodiscard]] double inverse_depth_max() const {
    return static_cast<double>(std::bit_cast<float>(~static_cast<std::uint32_t>(bits >> 32U)));
  }
  auto operator<=>(const CellEntry&) const = default;
};

}  // namespace tapestry::raster

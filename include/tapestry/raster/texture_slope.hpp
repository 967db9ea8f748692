#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <tapestry/core/array.hpp>
#include <tapestry/raster/texture_atlas.hpp>
#include <tapestry/raster/texture_layout.hpp>

namespace tapestry::raster {

/// Derivatives of a colour with respect to some coordinates: [channel][coordinate].
template <std::size_t Coordinates>
using ColourSlope = std::array<std::array<double, Coordinates>, 3>;

/// ∂colour/∂(u, v) of visit_atlas_taps()'s bilinear lookup. On a texel's centre, where it jumps, the side of
/// the greater index counts; beyond the outer texels' centres it is 0.
/// \param texels  [height · width, 3]
template <class Texels>
[[nodiscard]] ColourSlope<2> atlas_slope(const TextureLayout& layout, const Texels& texels,
                                         const std::array<double, 2>& uv) {
  const double u = detail::wrapped(uv[0], layout.u_extent) / layout.u_extent;
  const double v = detail::wrapped(uv[1], 1);
  const auto columns = static_cast<double>(layout.width), rows = static_cast<double>(layout.height);
  const detail::AxisTaps column(u * columns - 0.5, layout.width);
  const detail::AxisTaps row((1 - v) * rows - 0.5, layout.height);
  const bool moves_along_row = u * columns - 0.5 >= 0, moves_down = (1 - v) * rows - 0.5 >= 0;
  ColourSlope<2> slope{};
  for (std::size_t c = 0; c < 3; ++c) {
    const auto texel = [&](std::size_t i, std::size_t j) {
      return static_cast<double>(texels(i * layout.width + j, c));
    };
    const double upper = texel(row.first, column.second) - texel(row.first, column.first);
    const double lower = texel(row.second, column.second) - texel(row.second, column.first);
    const double left = texel(row.second, column.first) - texel(row.first, column.first);
    const double right = texel(row.second, column.second) - texel(row.first, column.second);
    if (moves_along_row)
      slope[c][0] = (upper * (1 - row.share) + lower * row.share) * columns / layout.u_extent;
    if (moves_down) slope[c][1] = -(left * (1 - column.share) + right * column.share) * rows;
  }
  return slope;
}

/// ∂colour/∂(b₀, b₁, b₂) of visit_cube_taps()'s lookup; 0 along a coordinate that is clamped.
/// \param texels  [F · s³, 3]
template <class Texels>
[[nodiscard]] ColourSlope<3> cube_slope(const TextureLayout& layout, const Texels& texels, std::size_t face,
                                        const std::array<double, 3>& barycentric) {
  const std::size_t edge = layout.texels_per_edge;
  const double last = static_cast<double>(edge) - 1;
  ColourSlope<3> slope{};
  if (edge < 2) return slope;
  std::array<std::size_t, 3> cell;
  std::array<double, 3> share;
  std::array<double, 3> scale;
  for (std::size_t k = 0; k < 3; ++k) {
    const double wanted = barycentric[k] * last, position = std::max(std::min(wanted, last - 1e-3), 0.0);
    cell[k] = static_cast<std::size_t>(position);
    share[k] = position - static_cast<double>(cell[k]);
    scale[k] = wanted >= 0 && wanted <= last - 1e-3 ? last : 0;
  }
  for (std::size_t corner = 0; corner < 8; ++corner) {
    std::size_t texel = face;
    std::array<double, 3> weight{}, sign{};
    for (std::size_t k = 0; k < 3; ++k) {
      const bool upper = ((corner >> k) & 1U) != 0;
      texel = texel * edge + cell[k] + (upper ? 1 : 0);
      weight[k] = upper ? share[k] : 1 - share[k];
      sign[k] = upper ? 1 : -1;
    }
    for (std::size_t k = 0; k < 3; ++k) {
      const double factor = sign[k] * scale[k] * weight[(k + 1) % 3] * weight[(k + 2) % 3];
      for (std::size_t c = 0; c < 3; ++c) slope[c][k] += factor * static_cast<double>(texels(texel, c));
    }
  }
  return slope;
}

}  // namespace tapestry::raster

#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <tapestry/raster/texture_layout.hpp>

namespace tapestry::raster {

/// Trilinear lookup in a face's cube of s³ texels: calls visit(Tap) up to eight times, with weights that
/// sum to 1.
///
///   c_k = clamp(b_k·(s − 1), 0, s − 1 − 10⁻³),   texel (a, b, c) at ((f·s + a)·s + b)·s + c,
/// where b_k is the perspective-correct barycentric coordinate, w_k·z/z_k in the source's terms.
/// Source: Neural Mesh Renderer, rasterisation kernel, with its eps of 10⁻³.
///
/// \param face         f
/// \param barycentric  b, in [0, 1]
template <class Visit>
void visit_cube_taps(const TextureLayout& layout, std::size_t face, const std::array<double, 3>& barycentric,
                     Visit visit) {
  const std::size_t edge = layout.texels_per_edge;
  const double last = static_cast<double>(edge) - 1;
  std::array<std::size_t, 3> cell;
  std::array<double, 3> share;
  for (std::size_t k = 0; k < 3; ++k) {
    const double position = std::max(std::min(barycentric[k] * last, last - 1e-3), 0.0);
    cell[k] = static_cast<std::size_t>(position);
    share[k] = position - static_cast<double>(cell[k]);
  }
  for (std::size_t corner = 0; corner < 8; ++corner) {
    std::size_t texel = face;
    double weight = 1;
    for (std::size_t k = 0; k < 3; ++k) {
      const bool upper = ((corner >> k) & 1U) != 0;
      texel = texel * edge + cell[k] + (upper ? 1 : 0);
      weight *= upper ? share[k] : 1 - share[k];
    }
    if (weight > 0) visit(Tap{texel, weight});
  }
}

}  // namespace tapestry::raster

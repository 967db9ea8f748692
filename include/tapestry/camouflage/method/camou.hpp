#pragma once
#include <algorithm>
#include <concepts>
#include <cstddef>
#include <memory>
#include <tapestry/camouflage/method/method.hpp>
#include <tapestry/camouflage/method/panels.hpp>
#include <tapestry/raster/painted_mesh.hpp>
#include <vector>

namespace tapestry::camouflage {

/// Colours along an edge of CAMOU's pattern.
inline constexpr std::size_t camou_pattern_edge = 16;

/// A pattern of 16 × 16 colours, row by row, that is repeated all over the atlas, at most four times along
/// its height: a colour fills a square of as few texels as allow it.
///
/// Source: Zhang et al., "CAMOU: Learning a Vehicle Camouflage for Physical Adversarial Attack on Object
/// Detectors in the Wild" (ICLR 2019), section 3. Faithful: the small repeated pattern. Simplified, in its
/// favour: its renderer has no gradient, so it learns a network that imitates renderer and detector, and
/// follows that one's; here the pattern follows the gradient itself.
///
/// \throws DomainError unless the texture is an atlas
template <std::floating_point T>
[[nodiscard]] Method<T> camou(const raster::PaintedMesh& car) {
  require_atlas("camou", car);
  constexpr std::size_t edge = camou_pattern_edge;
  const std::size_t height = car.layout.height, width = car.layout.width;
  const std::size_t texels_a_colour = (height + 4 * edge - 1) / (4 * edge);
  std::vector<std::size_t> rows(height * width);
  for (std::size_t y = 0; y < height; ++y)
    for (std::size_t x = 0; x < width; ++x)
      rows[y * width + x] = y / texels_a_colour % edge * edge + x / texels_a_colour % edge;
  Method<T> method;
  method.row_of_texel = std::make_shared<const std::vector<std::size_t>>(std::move(rows));
  method.row_count = edge * edge;
  return method;
}

}  // namespace tapestry::camouflage

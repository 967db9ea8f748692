#pragma once
#include <concepts>
#include <cstddef>
#include <tapestry/camouflage/method/method.hpp>
#include <tapestry/raster/painted_mesh.hpp>

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
[[nodiscard]] Method<T> camou(const raster::PaintedMesh& car);

}  // namespace tapestry::camouflage

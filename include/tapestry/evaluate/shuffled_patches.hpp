#pragma once
#include <concepts>
#include <cstddef>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/core/random.hpp>
#include <tapestry/raster/texture_charts.hpp>
#include <tapestry/raster/texture_layout.hpp>
#include <vector>

namespace tapestry::evaluate {

/// Extents of the patches that shuffled_patches() moves, in texels of a chart.
struct PatchExtents {
  std::size_t height = 1, width = 1;
};

/// atlas: squares of an eighth of its height; cube: the whole of a face; other kinds: single texels.
[[nodiscard]] PatchExtents patch_extents(const raster::TextureLayout& layout);

/// The control that keeps the parts of an optimised texture and not their arrangement: in each chart, patches
/// that lie wholly in it change places in one random cycle, so that none stays where it is. What is left over
/// between them and the chart's outline, and all of a chart with room for one patch only, is cut into patches
/// of half the extents, which change places among themselves, and so on down to single texels. Each texel
/// keeps its colour, somewhere in its chart.
///
/// \param colours  [texel, 3]
/// \param charts   of the texture, see raster::texture_charts(); no texel in two of them
/// \param patch    extents of the largest patches, see patch_extents()
/// \param random   not advanced; the same places for the same state
/// \returns        [texel, 3]; texels of no chart as they are
/// \throws DomainError for a patch without texels; ShapeError unless colours are [texel, 3] with the charts'
///         texels; NumericError for a colour in a chart that is not finite
template <std::floating_point T>
[[nodiscard]] Array<T, 2> shuffled_patches(const Array<T, 2>& colours,
                                           const std::vector<raster::TextureChart>& charts,
                                           PatchExtents patch, const Random& random);

}  // namespace tapestry::evaluate

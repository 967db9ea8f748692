#pragma once
#include <concepts>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/raster/texture_charts.hpp>
#include <vector>

namespace tapestry::evaluate::detail {

/// \throws ShapeError unless colours are [texel, 3] with the texels of the charts; NumericError for one of
///         these whose colour is not finite
template <std::floating_point T>
void require_chart_colours(const char* operation, const Array<T, 2>& colours,
                           const std::vector<raster::TextureChart>& charts);

}  // namespace tapestry::evaluate::detail

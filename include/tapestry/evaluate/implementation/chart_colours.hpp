#pragma once
#include <cmath>
#include <concepts>
#include <cstddef>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/evaluate/chart_colours.hpp>
#include <tapestry/raster/texture_charts.hpp>
#include <vector>

namespace tapestry::evaluate::detail {

template <std::floating_point T>
void require_chart_colours(const char* operation, const Array<T, 2>& colours,
                           const std::vector<raster::TextureChart>& charts) {
  if (colours.shape(1) != 3)
    throw ShapeError(std::string(operation) + ": colours are [" + std::to_string(colours.shape(0)) + ", " +
                     std::to_string(colours.shape(1)) + "], expected 3 channels");
  for (const raster::TextureChart& chart : charts)
    for (const raster::ChartTexel& texel : chart.texels) {
      if (texel.texel >= colours.shape(0))
        throw ShapeError(std::string(operation) + ": a chart has texel " + std::to_string(texel.texel) +
                         " of a texture of " + std::to_string(colours.shape(0)));
      for (std::size_t c = 0; c < 3; ++c)
        if (!std::isfinite(colours(texel.texel, c)))
          throw NumericError(std::string(operation) + ": texel " + std::to_string(texel.texel) +
                             " has a colour that is not finite");
    }
}

template decltype(require_chart_colours<float>) require_chart_colours<float>;
template decltype(require_chart_colours<double>) require_chart_colours<double>;

}  // namespace tapestry::evaluate::detail

#pragma once
#include <concepts>
#include <cstddef>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/raster/affine_colour.hpp>

namespace tapestry::raster {

/// affine_colour() on the active tape; its pullback is affine_colour_adjoint(). Passive inputs record
/// nothing. \throws ShapeError as affine_colour()
template <std::floating_point T, std::size_t Rank>
[[nodiscard]] ArrayVariable<T, 3> affine_colour(const ArrayVariable<T, 3>& image,
                                                const ArrayVariable<T, 2>& coverage,
                                                const ArrayVariable<T, Rank>& gain,
                                                const ArrayVariable<T, Rank>& bias) {
  const auto pullback = [i = image.shared_value(), c = coverage.shared_value(), g = gain.shared_value(),
                         b = bias.shared_value()](const Array<T, 3>& adjoint, auto*... inputs_adjoint) {
    affine_colour_adjoint(*i, *c, *g, *b, adjoint, inputs_adjoint...);
  };
  return record_array(affine_colour(image.value(), coverage.value(), gain.value(), bias.value()), pullback,
                      image, coverage, gain, bias);
}

}  // namespace tapestry::raster

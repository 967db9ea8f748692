#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/camouflage/texture_parameter.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/core/random.hpp>

namespace tapestry::camouflage {

template <class T>
Array<T, 2> parameter_of_colours(const Array<T, 2>& colours) {
  Array<T, 2> parameter(colours.shape());
  for (std::size_t i = 0; i < colours.size(); ++i) {
    const T c = std::clamp(colours.data()[i], T(colour_margin), T(1 - colour_margin));
    parameter.data()[i] = std::atanh(T(2) * c - T(1));
  }
  return parameter;
}

template <class T>
Array<T, 2> random_colours(std::size_t texel_count, Random& random) {
  Array<T, 2> colours(Extents<2>{texel_count, 3});
  for (T& value : colours.storage()) value = static_cast<T>(random.uniform(0.02, 0.98));
  return colours;
}

template <class T>
Array<T, 2> solid_colours(std::size_t texel_count, const std::array<double, 3>& colour) {
  Array<T, 2> colours(Extents<2>{texel_count, 3});
  for (std::size_t i = 0; i < colours.size(); ++i) colours.data()[i] = static_cast<T>(colour[i % 3]);
  return colours;
}

template decltype(parameter_of_colours<float>) parameter_of_colours<float>;
template decltype(parameter_of_colours<double>) parameter_of_colours<double>;
template decltype(random_colours<float>) random_colours<float>;
template decltype(random_colours<double>) random_colours<double>;
template decltype(solid_colours<float>) solid_colours<float>;
template decltype(solid_colours<double>) solid_colours<double>;

}  // namespace tapestry::camouflage

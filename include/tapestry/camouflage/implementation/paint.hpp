#pragma once
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tapestry/camouflage/paint.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/image/transform/colour_change.hpp>
#include <utility>
#include <vector>

namespace tapestry::camouflage {

template <class T>
Paint<T> without_paint(Array<T, 2> colours) {
  std::vector<std::uint8_t> painted(colours.shape(0), 0);
  return {std::move(colours), std::move(painted)};
}

template <class T>
void require_sound(const char* operation, const Paint<T>& paint) {
  if (!paint.painted.empty() && paint.painted.size() != paint.colours.shape(0))
    throw ShapeError(std::string(operation) + ": " + std::to_string(paint.painted.size()) +
                     " texels are paint or not, expected " + std::to_string(paint.colours.shape(0)));
}

template <std::floating_point T>
Array<T, 2> printed(const Paint<T>& paint, const image::ColourChange& print) {
  require_sound("printed", paint);
  const auto& [colours, painted] = paint;
  auto result = image::transformed(colours, print);
  for (std::size_t texel = 0; texel < painted.size(); ++texel)
    for (std::size_t c = 0; c < 3 && painted[texel] == 0; ++c) result(texel, c) = colours(texel, c);
  return result;
}

template decltype(without_paint<float>) without_paint<float>;
template decltype(without_paint<double>) without_paint<double>;
template void require_sound<float>(const char* operation, const Paint<float>& paint);
template void require_sound<double>(const char* operation, const Paint<double>& paint);
template Array<float, 2> printed<float>(const Paint<float>& paint, const image::ColourChange& print);
template Array<double, 2> printed<double>(const Paint<double>& paint, const image::ColourChange& print);

}  // namespace tapestry::camouflage

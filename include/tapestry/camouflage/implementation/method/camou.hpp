#pragma once
#include <algorithm>
#include <concepts>
#include <cstddef>
#include <memory>
#include <tapestry/camouflage/method/camou.hpp>
#include <tapestry/camouflage/method/method.hpp>
#include <tapestry/camouflage/method/panels.hpp>
#include <tapestry/raster/painted_mesh.hpp>
#include <vector>

namespace tapestry::camouflage {

template <std::floating_point T>
Method<T> camou(const raster::PaintedMesh& car) {
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

template decltype(camou<float>) camou<float>;
template decltype(camou<double>) camou<double>;

}  // namespace tapestry::camouflage

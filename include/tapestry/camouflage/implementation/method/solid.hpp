#pragma once
#include <concepts>
#include <cstddef>
#include <memory>
#include <tapestry/camouflage/method/method.hpp>
#include <tapestry/camouflage/method/solid.hpp>
#include <vector>

namespace tapestry::camouflage {

template <std::floating_point T>
Method<T> solid_paint(std::size_t texel_count) {
  Method<T> method;
  method.row_of_texel = std::make_shared<const std::vector<std::size_t>>(texel_count, std::size_t(0));
  method.row_count = 1;
  return method;
}

template decltype(solid_paint<float>) solid_paint<float>;
template decltype(solid_paint<double>) solid_paint<double>;

}  // namespace tapestry::camouflage

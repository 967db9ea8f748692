#pragma once
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <tapestry/camouflage/method/method.hpp>
#include <tapestry/camouflage/method/random.hpp>
#include <tapestry/camouflage/texture_parameter.hpp>
#include <tapestry/core/random.hpp>

namespace tapestry::camouflage {

template <std::floating_point T>
Method<T> random_paint(std::size_t texel_count, std::uint64_t seed) {
  Random noise = Random(seed).fork(0x6E6F697365ULL);
  Method<T> method;
  method.least = method.greatest = random_colours<T>(texel_count, noise);
  method.is_optimised = false;
  return method;
}

template decltype(random_paint<float>) random_paint<float>;
template decltype(random_paint<double>) random_paint<double>;

}  // namespace tapestry::camouflage

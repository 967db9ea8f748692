#pragma once
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <tapestry/camouflage/method/method.hpp>
#include <tapestry/core/random.hpp>

namespace tapestry::camouflage {

/// Noise, see random_colours(), that is not optimised: what covering the car in any pattern does.
///
/// Source: the control "random" of the tables; the papers lack it.
template <std::floating_point T>
[[nodiscard]] Method<T> random_paint(std::size_t texel_count, std::uint64_t seed) {
  Random noise = Random(seed).fork(0x6E6F697365ULL);
  Method<T> method;
  method.least = method.greatest = random_colours<T>(texel_count, noise);
  method.is_optimised = false;
  return method;
}

}  // namespace tapestry::camouflage

#pragma once
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <tapestry/camouflage/method/method.hpp>

namespace tapestry::camouflage {

/// Noise, see random_colours(), that is not optimised: what covering the car in any pattern does.
///
/// Source: the control "random" of the tables; the papers lack it.
template <std::floating_point T>
[[nodiscard]] Method<T> random_paint(std::size_t texel_count, std::uint64_t seed);

}  // namespace tapestry::camouflage

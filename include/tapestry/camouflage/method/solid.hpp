#pragma once
#include <concepts>
#include <cstddef>
#include <tapestry/camouflage/method/method.hpp>

namespace tapestry::camouflage {

/// One colour for the whole body, optimised as every other method is from the one that it begins with;
/// another start may end in another colour. What a pattern adds to it is what the pattern is for.
///
/// Source: ours; the papers measure single colours at most, as the solid controls of the tables do.
template <std::floating_point T>
[[nodiscard]] Method<T> solid_paint(std::size_t texel_count);

}  // namespace tapestry::camouflage

#pragma once
#include <concepts>
#include <cstddef>
#include <memory>
#include <tapestry/camouflage/method/method.hpp>
#include <vector>

namespace tapestry::camouflage {

/// One colour for the whole body, optimised as every other method is from the one that it begins with;
/// another start may end in another colour. What a pattern adds to it is what the pattern is for.
///
/// Source: ours; the papers measure single colours at most, as the solid controls of the tables do.
template <std::floating_point T>
[[nodiscard]] Method<T> solid_paint(std::size_t texel_count) {
  Method<T> method;
  method.row_of_texel = std::make_shared<const std::vector<std::size_t>>(texel_count, std::size_t(0));
  method.row_count = 1;
  return method;
}

}  // namespace tapestry::camouflage

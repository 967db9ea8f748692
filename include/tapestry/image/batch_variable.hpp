#pragma once
#include <concepts>
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/image/batch.hpp>
#include <vector>

namespace tapestry::image {

/// batch_of() of pictures on the tape, [N, H, W, C], such as a network takes.
/// \throws ShapeError as batch_of()
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 4> batch_of(const std::vector<ArrayVariable<T, 3>>& pictures);

}  // namespace tapestry::image

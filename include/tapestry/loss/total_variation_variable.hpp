#pragma once
#include <concepts>
#include <memory>
#include <tapestry/autodiff/variable.hpp>
#include <tapestry/core/compiled.hpp>
#include <tapestry/loss/neighbour_steps_variable.hpp>
#include <tapestry/loss/total_variation.hpp>
#include <vector>

namespace tapestry::loss {

/// total_variation() of a picture on the active tape; its pullback is total_variation_adjoint(). Arguments as
/// in smoothness() on the tape, errors as there and in total_variation().
template <std::floating_point T>
[[nodiscard]] Variable<T> total_variation(const ArrayVariable<T, 3>& picture, Array<T, 2> mask,
                                          double epsilon = total_variation_epsilon);

/// The sum over several pictures as one record.
template <std::floating_point T>
[[nodiscard]] Variable<T> total_variation(const std::vector<ArrayVariable<T, 3>>& pictures,
                                          SharedMasks<T> masks, double epsilon = total_variation_epsilon);

/// atlas_total_variation() of a texture on the active tape.
template <std::floating_point T>
[[nodiscard]] Variable<T> atlas_total_variation(const ArrayVariable<T, 2>& texels,
                                                std::shared_ptr<const Array<T, 2>> used,
                                                double epsilon = total_variation_epsilon);

}  // namespace tapestry::loss

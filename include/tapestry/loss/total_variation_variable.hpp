#pragma once
#include <concepts>
#include <memory>
#include <tapestry/loss/neighbour_steps_variable.hpp>
#include <tapestry/loss/total_variation.hpp>
#include <utility>
#include <vector>

namespace tapestry::loss {

/// total_variation() of a picture on the active tape; its pullback is total_variation_adjoint(). Arguments as
/// in smoothness() on the tape, errors as there and in total_variation().
template <std::floating_point T>
[[nodiscard]] Variable<T> total_variation(const ArrayVariable<T, 3>& picture, Array<T, 2> mask,
                                          double epsilon = total_variation_epsilon) {
  const auto penalty = detail::absolute_step("total_variation", epsilon);
  return detail::record_picture_steps("total_variation", penalty, picture, std::move(mask));
}

/// The sum over several pictures as one record.
template <std::floating_point T>
[[nodiscard]] Variable<T> total_variation(const std::vector<ArrayVariable<T, 3>>& pictures,
                                          SharedMasks<T> masks, double epsilon = total_variation_epsilon) {
  const auto penalty = detail::absolute_step("total_variation", epsilon);
  return detail::record_picture_steps("total_variation", penalty, pictures, std::move(masks));
}

/// atlas_total_variation() of a texture on the active tape.
template <std::floating_point T>
[[nodiscard]] Variable<T> atlas_total_variation(const ArrayVariable<T, 2>& texels,
                                                std::shared_ptr<const Array<T, 2>> used,
                                                double epsilon = total_variation_epsilon) {
  const auto penalty = detail::absolute_step("atlas_total_variation", epsilon);
  return detail::record_atlas_steps("atlas_total_variation", penalty, texels, std::move(used));
}

}  // namespace tapestry::loss

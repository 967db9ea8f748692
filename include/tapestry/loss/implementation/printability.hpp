#pragma once
#include <tapestry/autodiff/record.hpp>
#include <tapestry/loss/detail/neighbour_steps.hpp>
#include <tapestry/loss/detail/total_variation.hpp>
#include <tapestry/loss/printability.hpp>

namespace tapestry::loss {

template <std::floating_point T>
Variable<T> non_printability(const ArrayVariable<T, 2>& texels, std::shared_ptr<const Array<T, 2>> used,
                             std::shared_ptr<const Array<double, 2>> palette, double spread) {
  const T value = non_printability(texels.value(), *used, *palette, spread);
  const auto pullback = [at = texels.shared_value(), of_texels = std::move(used),
                         printable = std::move(palette), spread](T adjoint, Array<T, 2>* texels_adjoint) {
    non_printability_adjoint(*at, *of_texels, *printable, spread, adjoint, *texels_adjoint);
  };
  return record_scalar(value, pullback, texels);
}

template <std::floating_point T>
Variable<T> total_variation(const ArrayVariable<T, 3>& picture, Array<T, 2> mask, double epsilon) {
  const auto penalty = detail::absolute_step("total_variation", epsilon);
  return detail::record_picture_steps("total_variation", penalty, picture, std::move(mask));
}

template <std::floating_point T>
Variable<T> total_variation(const std::vector<ArrayVariable<T, 3>>& pictures, SharedMasks<T> masks,
                            double epsilon) {
  const auto penalty = detail::absolute_step("total_variation", epsilon);
  return detail::record_picture_steps("total_variation", penalty, pictures, std::move(masks));
}

template <std::floating_point T>
Variable<T> atlas_total_variation(const ArrayVariable<T, 2>& texels, std::shared_ptr<const Array<T, 2>> used,
                                  double epsilon) {
  const auto penalty = detail::absolute_step("atlas_total_variation", epsilon);
  return detail::record_atlas_steps("atlas_total_variation", penalty, texels, std::move(used));
}

}  // namespace tapestry::loss

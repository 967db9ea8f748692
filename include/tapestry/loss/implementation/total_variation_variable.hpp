#pragma once
#include <concepts>
#include <memory>
#include <tapestry/loss/neighbour_steps_variable.hpp>
#include <tapestry/loss/total_variation.hpp>
#include <tapestry/loss/total_variation_variable.hpp>
#include <utility>
#include <vector>

namespace tapestry::loss {

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

template Variable<float> total_variation<float>(const ArrayVariable<float, 3>& picture, Array<float, 2> mask,
                                                double epsilon);
template Variable<double> total_variation<double>(const ArrayVariable<double, 3>& picture,
                                                  Array<double, 2> mask, double epsilon);
template Variable<float> total_variation<float>(const std::vector<ArrayVariable<float, 3>>& pictures,
                                                SharedMasks<float> masks, double epsilon);
template Variable<double> total_variation<double>(const std::vector<ArrayVariable<double, 3>>& pictures,
                                                  SharedMasks<double> masks, double epsilon);
template Variable<float> atlas_total_variation<float>(const ArrayVariable<float, 2>& texels,
                                                      std::shared_ptr<const Array<float, 2>> used,
                                                      double epsilon);
template Variable<double> atlas_total_variation<double>(const ArrayVariable<double, 2>& texels,
                                                        std::shared_ptr<const Array<double, 2>> used,
                                                        double epsilon);

}  // namespace tapestry::loss

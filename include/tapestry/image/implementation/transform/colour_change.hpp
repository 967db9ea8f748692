#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <concepts>
#include <cstddef>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/image/transform/colour_change.hpp>

namespace tapestry::image {

ColourChange contrast_and_saturation(double contrast, double saturation) {
  const Eigen::RowVector3d luma(0.299, 0.587, 0.114);
  const Eigen::Matrix3d saturated =
      saturation * Eigen::Matrix3d::Identity() + (1 - saturation) * Eigen::Vector3d::Ones() * luma;
  return {contrast * saturated, Eigen::Vector3d::Constant((1 - contrast) / 2)};
}

}  // namespace tapestry::image

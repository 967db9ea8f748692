#pragma once
#include <concepts>
#include <cstddef>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/image/transform/blur.hpp>
#include <tapestry/image/transform/chain.hpp>
#include <tapestry/image/transform/colour_change.hpp>
#include <tapestry/image/transform/jpeg_compression.hpp>
#include <tapestry/image/transform/light_change.hpp>
#include <tapestry/image/transform/sensor_noise.hpp>
#include <tapestry/image/transform/warp.hpp>
#include <utility>
#include <variant>
#include <vector>

namespace tapestry::image {

template <std::floating_point T>
std::vector<Array<T, 3>> transformation_stages(Array<T, 3> picture, const TransformationChain& chain) {
  std::vector<Array<T, 3>> stages;
  stages.reserve(chain.size() + 1);
  stages.push_back(std::move(picture));
  for (const Transformation& transformation : chain)
    stages.push_back(
        std::visit([&](const auto& one) { return transformed(stages.back(), one); }, transformation));
  return stages;
}

template <std::floating_point T>
Array<T, 3> transformed(Array<T, 3> picture, const TransformationChain& chain) {
  for (const Transformation& transformation : chain)
    picture = std::visit([&](const auto& one) { return transformed(picture, one); }, transformation);
  return picture;
}

template <std::floating_point T>
void transformed_adjoint(const std::vector<Array<T, 3>>& stages, const TransformationChain& chain,
                         const Array<T, 3>& out_adjoint, Array<T, 3>& picture_adjoint) {
  if (stages.size() != chain.size() + 1) throw ShapeError("transformed_adjoint: stages of another chain");
  require_shape("transformed_adjoint", "out_adjoint", out_adjoint, stages.back().shape());
  require_shape("transformed_adjoint", "picture_adjoint", picture_adjoint, stages.back().shape());
  Array<T, 3> adjoint = out_adjoint;
  for (std::size_t i = chain.size(); i-- > 0;) {
    Array<T, 3> before = xt::zeros_like(adjoint);
    std::visit([&](const auto& one) { transformed_adjoint(stages[i], one, adjoint, before); }, chain[i]);
    adjoint = std::move(before);
  }
  for (std::size_t i = 0; i < adjoint.size(); ++i) picture_adjoint.data()[i] += adjoint.data()[i];
}

template decltype(transformation_stages<float>) transformation_stages<float>;
template decltype(transformation_stages<double>) transformation_stages<double>;
template Array<float, 3> transformed<float>(Array<float, 3> picture, const TransformationChain& chain);
template Array<double, 3> transformed<double>(Array<double, 3> picture, const TransformationChain& chain);
template void transformed_adjoint<float>(const std::vector<Array<float, 3>>& stages,
                                         const TransformationChain& chain, const Array<float, 3>& out_adjoint,
                                         Array<float, 3>& picture_adjoint);
template void transformed_adjoint<double>(const std::vector<Array<double, 3>>& stages,
                                          const TransformationChain& chain,
                                          const Array<double, 3>& out_adjoint,
                                          Array<double, 3>& picture_adjoint);

}  // namespace tapestry::image

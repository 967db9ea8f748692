#pragma once
#include <concepts>
#include <cstddef>
#include <memory>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/raster/texture_operator.hpp>
#include <tapestry/raster/texture_operator_variable.hpp>
#include <utility>
#include <vector>

namespace tapestry::raster::detail {

/// Adds every view's render_adjoint(), in the order of views; those without an adjoint add nothing. A small
/// texture gets a part a view, so that views are independent of one another.
template <class T>
void add_render_adjoints(const std::vector<std::shared_ptr<const TextureOperator<T>>>& pictures,
                         const std::vector<const Array<T, 3>*>& render_adjoints,
                         Array<T, 2>& texels_adjoint) {
  constexpr std::size_t small_texture = 1U << 18U;  // values
  if (texels_adjoint.size() > small_texture) {
    for (std::size_t n = 0; n < pictures.size(); ++n)
      if (render_adjoints[n] != nullptr) render_adjoint(*pictures[n], *render_adjoints[n], texels_adjoint);
    return;
  }
  std::vector<Array<T, 2>> parts(pictures.size());
  parallel_for(pictures.size(), [&](std::size_t n) {
    if (render_adjoints[n] == nullptr) return;
    parts[n] = zeros<T, 2>(texels_adjoint.shape());
    render_adjoint(*pictures[n], *render_adjoints[n], parts[n]);
  });
  for (const auto& part : parts)
    for (std::size_t i = 0; i < part.size(); ++i) texels_adjoint.data()[i] += part.data()[i];
}

}  // namespace tapestry::raster::detail

namespace tapestry::raster {

template <std::floating_point T>
ArrayVariable<T, 3> render(const TextureOperator<T>& picture, const ArrayVariable<T, 2>& texels) {
  const auto pullback = [&picture](const Array<T, 3>& adjoint, Array<T, 2>* texels_adjoint) {
    render_adjoint(picture, adjoint, *texels_adjoint);
  };
  return record_array(render(picture, texels.value()), pullback, texels);
}

template <std::floating_point T>
std::vector<ArrayVariable<T, 3>> render(
    const std::vector<std::shared_ptr<const TextureOperator<T>>>& pictures,
    const ArrayVariable<T, 2>& texels) {
  std::vector<Array<T, 3>> values(pictures.size());
  parallel_for(values.size(), [&](std::size_t n) { values[n] = render(*pictures[n], texels.value()); });
  const auto pullback = [pictures](const std::vector<const Array<T, 3>*>& adjoints,
                                   Array<T, 2>* texels_adjoint) {
    detail::add_render_adjoints(pictures, adjoints, *texels_adjoint);
  };
  return record_arrays<T, 3>(std::move(values), pullback, texels);
}

template ArrayVariable<float, 3> render<float>(const TextureOperator<float>& picture,
                                               const ArrayVariable<float, 2>& texels);
template ArrayVariable<double, 3> render<double>(const TextureOperator<double>& picture,
                                                 const ArrayVariable<double, 2>& texels);
template std::vector<ArrayVariable<float, 3>> render<float>(
    const std::vector<std::shared_ptr<const TextureOperator<float>>>& pictures,
    const ArrayVariable<float, 2>& texels);
template std::vector<ArrayVariable<double, 3>> render<double>(
    const std::vector<std::shared_ptr<const TextureOperator<double>>>& pictures,
    const ArrayVariable<double, 2>& texels);

}  // namespace tapestry::raster

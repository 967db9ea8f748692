#pragma once
#include <algorithm>
#include <concepts>
#include <cstddef>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>

namespace tapestry::segment {
namespace detail {

/// Of the first largest value.
template <class T>
[[nodiscard]] std::size_t brightest(const Array<T, 3>& picture) {
  return static_cast<std::size_t>(std::max_element(picture.data(), picture.data() + picture.size()) -
                                  picture.data());
}
}  // namespace detail

/// A picture as a network of the U²-Net family takes it: divided by its largest value, then scaled by mean
/// and standard deviation of ImageNet.
///
///   x[i, j, c] = (p[i, j, c] / max p − mean[c]) / deviation[c]
///
/// Source: U-2-Net, data_loader.py, ToTensorLab with flag 0. A black picture is not divided.
///
/// \param picture  p, [S, S, 3], RGB in [0, 1]
/// \returns        [S, S, 3]
/// \throws ShapeError unless there are three channels
template <std::floating_point T>
[[nodiscard]] Array<T, 3> u2_net_input(const Array<T, 3>& picture);

/// Adds (∂x/∂p)ᵀ · input_adjoint to picture_adjoint, [S, S, 3]. Among equal largest values the first is the
/// one that all are divided by.
template <std::floating_point T>
void u2_net_input_adjoint(const Array<T, 3>& picture, const Array<T, 3>& input_adjoint,
                          Array<T, 3>& picture_adjoint);

}  // namespace tapestry::segment

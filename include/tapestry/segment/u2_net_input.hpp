#pragma once
#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/core/finite.hpp>

namespace tapestry::segment {
namespace detail {
inline constexpr std::array<double, 3> u2_net_mean{0.485, 0.456, 0.406};
inline constexpr std::array<double, 3> u2_net_deviation{0.229, 0.224, 0.225};

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
[[nodiscard]] Array<T, 3> u2_net_input(const Array<T, 3>& picture) {
  require_shape("u2_net_input", "picture", picture, {picture.shape(0), picture.shape(1), 3});
  Array<T, 3> input(picture.shape());
  const T largest = picture.size() == 0 ? T(0) : picture.data()[detail::brightest(picture)];
  const double scale = largest > T(0) ? 1 / static_cast<double>(largest) : 1;
  for (std::size_t i = 0; i < picture.size(); ++i)
    input.data()[i] =
        static_cast<T>((static_cast<double>(picture.data()[i]) * scale - detail::u2_net_mean[i % 3]) /
                       detail::u2_net_deviation[i % 3]);
  return input;
}

/// Adds (∂x/∂p)ᵀ · input_adjoint to picture_adjoint, [S, S, 3]. Among equal largest values the first is the
/// one that all are divided by.
template <std::floating_point T>
void u2_net_input_adjoint(const Array<T, 3>& picture, const Array<T, 3>& input_adjoint,
                          Array<T, 3>& picture_adjoint) {
  require_shape("u2_net_input_adjoint", "picture", picture, {picture.shape(0), picture.shape(1), 3});
  require_shape("u2_net_input_adjoint", "input_adjoint", input_adjoint, picture.shape());
  require_shape("u2_net_input_adjoint", "picture_adjoint", picture_adjoint, picture.shape());
  if (picture.size() == 0) return;
  const std::size_t place = detail::brightest(picture);
  const auto largest = static_cast<double>(picture.data()[place]);
  const double scale = largest > 0 ? 1 / largest : 1;
  double along_picture = 0;  // Σ x̄ · p / deviation
  for (std::size_t i = 0; i < picture.size(); ++i) {
    const double share = static_cast<double>(input_adjoint.data()[i]) / detail::u2_net_deviation[i % 3];
    picture_adjoint.data()[i] += static_cast<T>(share * scale);
    along_picture += share * static_cast<double>(picture.data()[i]);
  }
  if (largest > 0) picture_adjoint.data()[place] -= static_cast<T>(along_picture * scale * scale);
}

}  // namespace tapestry::segment

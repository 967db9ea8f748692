#pragma once
#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/core/finite.hpp>
#include <tapestry/segment/u2_net_input.hpp>

namespace tapestry::segment::detail {

inline constexpr std::array<double, 3> u2_net_mean{0.485, 0.456, 0.406};

inline constexpr std::array<double, 3> u2_net_deviation{0.229, 0.224, 0.225};

}  // namespace tapestry::segment::detail

namespace tapestry::segment {

template <std::floating_point T>
Array<T, 3> u2_net_input(const Array<T, 3>& picture) {
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

template decltype(u2_net_input<float>) u2_net_input<float>;
template decltype(u2_net_input<double>) u2_net_input<double>;
template decltype(u2_net_input_adjoint<float>) u2_net_input_adjoint<float>;
template decltype(u2_net_input_adjoint<double>) u2_net_input_adjoint<double>;

}  // namespace tapestry::segment

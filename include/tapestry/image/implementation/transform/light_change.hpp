#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/image/transform/light_change.hpp>
#include <tapestry/image/transform/rows.hpp>

namespace tapestry::image::detail {

/// What a pixel's encoded channels are multiplied by.
class LightFactors {
 public:
  LightFactors(const LightChange& change, std::size_t height, std::size_t width)
      : change_(change),
        across_(std::cos(change.shadow_rad)),
        down_(std::sin(change.shadow_rad)),
        middle_x_(static_cast<double>(width) / 2),
        middle_y_(static_cast<double>(height) / 2) {
    const bool is_light = change.gain[0] > 0 && change.gain[1] > 0 && change.gain[2] > 0;
    if (!is_light || !(change.shadow >= 0 && change.shadow < 1) || !(change.shadow_softness > 0))
      throw DomainError("light change: gains and softness must be above 0, a shadow 0 to below 1");
    for (std::size_t c = 0; c < 3; ++c) gain_[c] = encoded(change.gain[c]);
  }

  [[nodiscard]] std::array<double, 3> operator()(std::size_t x, std::size_t y) const {
    if (change_.shadow == 0) return gain_;
    const double place = (across_ * (static_cast<double>(x) + 0.5 - middle_x_) +
                          down_ * (static_cast<double>(y) + 0.5 - middle_y_)) /
                         middle_x_;
    const double edge =
        std::clamp((place - change_.shadow_at) / (2 * change_.shadow_softness) + 0.5, 0.0, 1.0);
    if (edge == 0) return gain_;
    const double left = encoded(1 - change_.shadow * edge * edge * (3 - 2 * edge));
    return {gain_[0] * left, gain_[1] * left, gain_[2] * left};
  }

 private:
  static double encoded(double light) { return std::pow(light, 1 / 2.2); }

  LightChange change_;
  double across_, down_, middle_x_, middle_y_;
  std::array<double, 3> gain_{};
};

}  // namespace tapestry::image::detail

namespace tapestry::image {

template <std::floating_point T>
Array<T, 3> transformed(const Array<T, 3>& picture, const LightChange& change) {
  const std::size_t width = picture.shape(1);
  require_shape("transformed", "picture", picture, {picture.shape(0), width, 3});
  Array<T, 3> out(picture.shape());
  const detail::LightFactors factors(change, picture.shape(0), width);
  detail::for_each_row(picture.shape(0), [&](std::size_t y) {
    for (std::size_t x = 0; x < width; ++x) {
      const auto factor = factors(x, y);
      for (std::size_t c = 0; c < 3; ++c)
        out(y, x, c) = std::min(T(1), static_cast<T>(factor[c]) * picture(y, x, c));
    }
  });
  return out;
}

template <std::floating_point T>
void transformed_adjoint(const Array<T, 3>& picture, const LightChange& change,
                         const Array<T, 3>& out_adjoint, Array<T, 3>& picture_adjoint) {
  const std::size_t width = picture.shape(1);
  require_shape("transformed_adjoint", "picture", picture, {picture.shape(0), width, 3});
  require_shape("transformed_adjoint", "out_adjoint", out_adjoint, picture.shape());
  require_shape("transformed_adjoint", "picture_adjoint", picture_adjoint, picture.shape());
  const detail::LightFactors factors(change, picture.shape(0), width);
  detail::for_each_row(picture.shape(0), [&](std::size_t y) {
    for (std::size_t x = 0; x < width; ++x) {
      const auto factor = factors(x, y);
      for (std::size_t c = 0; c < 3; ++c)
        if (const T slope = static_cast<T>(factor[c]); slope * picture(y, x, c) < 1)
          picture_adjoint(y, x, c) += slope * out_adjoint(y, x, c);
    }
  });
}

template Array<float, 3> transformed<float>(const Array<float, 3>& picture, const LightChange& change);
template Array<double, 3> transformed<double>(const Array<double, 3>& picture, const LightChange& change);
template void transformed_adjoint<float>(const Array<float, 3>& picture, const LightChange& change,
                                         const Array<float, 3>& out_adjoint,
                                         Array<float, 3>& picture_adjoint);
template void transformed_adjoint<double>(const Array<double, 3>& picture, const LightChange& change,
                                          const Array<double, 3>& out_adjoint,
                                          Array<double, 3>& picture_adjoint);

}  // namespace tapestry::image

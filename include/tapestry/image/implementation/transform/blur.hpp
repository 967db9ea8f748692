#pragma once
#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdlib>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/image/transform/blur.hpp>
#include <tapestry/image/transform/rows.hpp>
#include <vector>

namespace tapestry::image::detail {

/// Weights of the samples −r … r around a pixel, r = ⌈3σ⌉; their sum is 1.
inline std::vector<double> gaussian_weights(double deviation_px) {
  if (!(deviation_px >= 0 && deviation_px <= 64))
    throw DomainError("blur: a standard deviation of " + std::to_string(deviation_px) +
                      " pixels is not 0 to 64");
  const auto radius = static_cast<std::ptrdiff_t>(std::ceil(3 * deviation_px));
  std::vector<double> weights;
  double sum = 0;
  for (std::ptrdiff_t i = -radius; i <= radius; ++i) {
    const double distance = radius == 0 ? 0 : static_cast<double>(i) / deviation_px;
    sum += weights.emplace_back(std::exp(-distance * distance / 2));
  }
  for (double& weight : weights) weight /= sum;
  return weights;
}

/// The weight of sample j in the blurred sample i of a line that goes on as at its ends: sample 0 stands for
/// all before it, sample `last` for all behind.
inline double blur_weight(const std::vector<double>& weights, std::ptrdiff_t i, std::ptrdiff_t j,
                          std::ptrdiff_t last) {
  const auto radius = static_cast<std::ptrdiff_t>(weights.size() / 2);
  double sum = 0;
  for (std::ptrdiff_t tap = j == 0 ? -radius : j - i; tap <= (j == last ? radius : j - i); ++tap)
    if (std::abs(tap) <= radius) sum += weights[static_cast<std::size_t>(tap + radius)];
  return sum;
}

template <class T>
using RowOfPicture = Eigen::Map<Eigen::Array<T, Eigen::Dynamic, 1>>;
template <class T>
using ConstRowOfPicture = Eigen::Map<const Eigen::Array<T, Eigen::Dynamic, 1>>;
/// Rows mixed along columns: by the weight of row j in row i, or, for the transpose, of row i in row j.
template <class T>
Array<T, 3> mixed_down(const Array<T, 3>& picture, const std::vector<double>& weights, bool is_transposed) {
  if (weights.size() == 1) return picture;
  const auto radius = static_cast<std::ptrdiff_t>(weights.size() / 2);
  const auto last = static_cast<std::ptrdiff_t>(picture.shape(0)) - 1;
  const auto row = static_cast<std::ptrdiff_t>(picture.shape(1) * picture.shape(2));
  Array<T, 3> out = xt::zeros_like(picture);
  for_each_row(picture.shape(0), [&](std::size_t y) {
    const auto i = static_cast<std::ptrdiff_t>(y);
    RowOfPicture<T> to(out.data() + i * row, row);
    for (std::ptrdiff_t j = std::max<std::ptrdiff_t>(0, i - radius); j <= std::min(last, i + radius); ++j)
      to += static_cast<T>(is_transposed ? blur_weight(weights, j, i, last)
                                         : blur_weight(weights, i, j, last)) *
            ConstRowOfPicture<T>(picture.data() + j * row, row);
  });
  return out;
}

/// Pixels mixed along rows. A row is laid out with what stands before and behind it; the transpose collects
/// such a row, and adds what has come to lie there to its ends.
template <class T>
Array<T, 3> mixed_across(const Array<T, 3>& picture, const std::vector<double>& weights, bool is_transposed) {
  if (weights.size() == 1) return picture;
  const auto taps = static_cast<std::ptrdiff_t>(weights.size()), radius = taps / 2;
  const auto channels = static_cast<std::ptrdiff_t>(picture.shape(2));
  const auto row = static_cast<std::ptrdiff_t>(picture.shape(1)) * channels;
  Array<T, 3> out = xt::zeros_like(picture);
  for_each_row(picture.shape(0), [&](std::size_t y) {
    const ConstRowOfPicture<T> from(picture.data() + static_cast<std::ptrdiff_t>(y) * row, row);
    RowOfPicture<T> to(out.data() + static_cast<std::ptrdiff_t>(y) * row, row);
    Eigen::Array<T, Eigen::Dynamic, 1> wide =
        Eigen::Array<T, Eigen::Dynamic, 1>::Zero(row + 2 * radius * channels);
    const auto weight = [&](std::ptrdiff_t tap) {
      return static_cast<T>(weights[static_cast<std::size_t>(tap)]);
    };
    if (is_transposed) {
      for (std::ptrdiff_t tap = 0; tap < taps; ++tap) wide.segment(tap * channels, row) += weight(tap) * from;
      to = wide.segment(radius * channels, row);
      for (std::ptrdiff_t x = 0; x < radius; ++x) {
        to.head(channels) += wide.segment(x * channels, channels);
        to.tail(channels) += wide.segment((radius + x) * channels + row, channels);
      }
      return;
    }
    wide.segment(radius * channels, row) = from;
    for (std::ptrdiff_t x = 0; x < radius; ++x) {
      wide.segment(x * channels, channels) = from.head(channels);
      wide.segment((radius + x) * channels + row, channels) = from.tail(channels);
    }
    for (std::ptrdiff_t tap = 0; tap < taps; ++tap) to += weight(tap) * wide.segment(tap * channels, row);
  });
  return out;
}

}  // namespace tapestry::image::detail

namespace tapestry::image {

template <std::floating_point T>
Array<T, 3> transformed(const Array<T, 3>& picture, const Blur& blur) {
  const auto across = detail::mixed_across(picture, detail::gaussian_weights(blur.across_px), false);
  return detail::mixed_down(across, detail::gaussian_weights(blur.down_px), false);
}

template <std::floating_point T>
void transformed_adjoint(const Array<T, 3>& picture, const Blur& blur, const Array<T, 3>& out_adjoint,
                         Array<T, 3>& picture_adjoint) {
  require_shape("transformed_adjoint", "out_adjoint", out_adjoint, picture.shape());
  require_shape("transformed_adjoint", "picture_adjoint", picture_adjoint, picture.shape());
  const auto down = detail::mixed_down(out_adjoint, detail::gaussian_weights(blur.down_px), true);
  const auto across = detail::mixed_across(down, detail::gaussian_weights(blur.across_px), true);
  for (std::size_t i = 0; i < across.size(); ++i) picture_adjoint.data()[i] += across.data()[i];
}

template Array<float, 3> transformed<float>(const Array<float, 3>& picture, const Blur& blur);
template Array<double, 3> transformed<double>(const Array<double, 3>& picture, const Blur& blur);
template void transformed_adjoint<float>(const Array<float, 3>& picture, const Blur& blur,
                                         const Array<float, 3>& out_adjoint,
                                         Array<float, 3>& picture_adjoint);
template void transformed_adjoint<double>(const Array<double, 3>& picture, const Blur& blur,
                                          const Array<double, 3>& out_adjoint,
                                          Array<double, 3>& picture_adjoint);

}  // namespace tapestry::image

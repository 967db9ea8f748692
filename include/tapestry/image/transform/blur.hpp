#pragma once
#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/image/transform/rows.hpp>
#include <vector>

namespace tapestry::image {

/// A Gaussian blur, as of a lens out of focus; of unequal deviations roughly that of a moving camera.
struct Blur {
  double across_px = 0;  ///< standard deviation along rows, at most 64
  double down_px = 0;    ///< and along columns
};

namespace detail {

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

/// Pictures as rows of one axis: position i of a line lies at i · stride.
struct LineWalk {
  std::size_t lines, length, stride, channels, line_stride;
};

template <class T>
LineWalk walk_across(const Array<T, 3>& p) {
  return {p.shape(0), p.shape(1), p.shape(2), p.shape(2), p.shape(1) * p.shape(2)};
}
template <class T>
LineWalk walk_down(const Array<T, 3>& p) {
  return {p.shape(1), p.shape(0), p.shape(1) * p.shape(2), p.shape(2), p.shape(2)};
}

/// Calls mix(position of out, position of in, weight) for all pairs along all lines; a line and its sums
/// belong to one thread. Beyond its ends a line goes on as at its end.
template <class Mix>
void for_each_weighted_pair(const LineWalk& walk, const std::vector<double>& weights, Mix mix) {
  const auto radius = static_cast<std::ptrdiff_t>(weights.size() / 2);
  const auto last = static_cast<std::ptrdiff_t>(walk.length) - 1;
  for_each_row(walk.lines, [&](std::size_t line) {
    const std::size_t begin = line * walk.line_stride;
    for (std::ptrdiff_t i = 0; i <= last; ++i)
      for (std::ptrdiff_t tap = -radius; tap <= radius; ++tap) {
        const auto from = static_cast<std::size_t>(std::clamp<std::ptrdiff_t>(i + tap, 0, last));
        mix(begin + static_cast<std::size_t>(i) * walk.stride, begin + from * walk.stride,
            weights[static_cast<std::size_t>(tap + radius)]);
      }
  });
}

template <class T>
Array<T, 3> blurred_along(const Array<T, 3>& picture, const LineWalk& walk, double deviation_px) {
  const auto weights = gaussian_weights(deviation_px);
  if (weights.size() == 1) return picture;
  Array<T, 3> out = xt::zeros_like(picture);
  for_each_weighted_pair(walk, weights, [&](std::size_t to, std::size_t from, double weight) {
    for (std::size_t c = 0; c < walk.channels; ++c)
      out.data()[to + c] += static_cast<T>(weight) * picture.data()[from + c];
  });
  return out;
}

template <class T>
Array<T, 3> transposed_blur_along(const Array<T, 3>& out_adjoint, const LineWalk& walk, double deviation_px) {
  const auto weights = gaussian_weights(deviation_px);
  if (weights.size() == 1) return out_adjoint;
  Array<T, 3> adjoint = xt::zeros_like(out_adjoint);
  for_each_weighted_pair(walk, weights, [&](std::size_t to, std::size_t from, double weight) {
    for (std::size_t c = 0; c < walk.channels; ++c)
      adjoint.data()[from + c] += static_cast<T>(weight) * out_adjoint.data()[to + c];
  });
  return adjoint;
}

}  // namespace detail

/// The blurred picture; beyond its edges it goes on as at the edge, so that a constant stays one.
///
/// \param picture  [H, W, C], not empty
/// \returns        [H, W, C]
/// \throws DomainError for a deviation that is negative or above 64 pixels
template <std::floating_point T>
[[nodiscard]] Array<T, 3> transformed(const Array<T, 3>& picture, const Blur& blur) {
  const auto along_rows = detail::blurred_along(picture, detail::walk_across(picture), blur.across_px);
  return detail::blurred_along(along_rows, detail::walk_down(picture), blur.down_px);
}

/// Adds the transpose of transformed() times `out_adjoint` to `picture_adjoint`; all are [H, W, C].
/// \throws ShapeError if extents differ, or as transformed()
template <std::floating_point T>
void transformed_adjoint(const Array<T, 3>& picture, const Blur& blur, const Array<T, 3>& out_adjoint,
                         Array<T, 3>& picture_adjoint) {
  require_shape("transformed_adjoint", "out_adjoint", out_adjoint, picture.shape());
  require_shape("transformed_adjoint", "picture_adjoint", picture_adjoint, picture.shape());
  const auto down = detail::transposed_blur_along(out_adjoint, detail::walk_down(out_adjoint), blur.down_px);
  const auto across = detail::transposed_blur_along(down, detail::walk_across(down), blur.across_px);
  for (std::size_t i = 0; i < across.size(); ++i) picture_adjoint.data()[i] += across.data()[i];
}

}  // namespace tapestry::image

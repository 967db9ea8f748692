#pragma once
#include <tapestry/core/random.hpp>
#include <tapestry/image/detail/transform/camera_effects.hpp>

namespace tapestry::image {
namespace detail {
/// Weights of the samples −r … r around a pixel, r = ⌈3σ⌉; their sum is 1.
inline std::vector<double> gaussian_weights(double deviation_px) {
  if (!(deviation_px >= 0 && deviation_px <= 64))
    throw DomainError({"blur: a standard deviation of ", deviation_px, " pixels is not 0 to 64"});
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

/// The weight of sample j in the blurred sample i of a line that continues with its end values: sample 0
/// stands for all before it, sample `last` for all behind.
inline double blur_weight(const std::vector<double>& weights, std::ptrdiff_t i, std::ptrdiff_t j,
                          std::ptrdiff_t last) {
  const auto radius = static_cast<std::ptrdiff_t>(weights.size() / 2);
  double sum = 0;
  for (std::ptrdiff_t tap = j == 0 ? -radius : j - i; tap <= (j == last ? radius : j - i); ++tap)
    if (std::abs(tap) <= radius) sum += weights[static_cast<std::size_t>(tap + radius)];
  return sum;
}

/// to[i] += weight · from[i]
template <std::floating_point T>
void add_weighted(const T* from, double weight, std::size_t count, T* to) {
  const T factor = static_cast<T>(weight);
  for (std::size_t i = 0; i < count; ++i) to[i] += factor * from[i];
}

/// Rows mixed along columns: by the weight of row j in row i, or, for the transpose, of row i in row j.
template <std::floating_point T>
Array<T, 3> mixed_down(const Array<T, 3>& picture, const std::vector<double>& weights, bool is_transposed) {
  if (weights.size() == 1) return picture;
  const auto radius = static_cast<std::ptrdiff_t>(weights.size() / 2);
  const auto last = static_cast<std::ptrdiff_t>(picture.shape(0)) - 1;
  const std::size_t row = picture.shape(1) * picture.shape(2);
  Array<T, 3> out = xt::zeros_like(picture);
  for_each_row(picture.shape(0), [&](std::size_t y) {
    const auto i = static_cast<std::ptrdiff_t>(y);
    for (std::ptrdiff_t j = std::max<std::ptrdiff_t>(0, i - radius); j <= std::min(last, i + radius); ++j)
      add_weighted(picture.data() + static_cast<std::size_t>(j) * row,
                   is_transposed ? blur_weight(weights, j, i, last) : blur_weight(weights, i, j, last), row,
                   out.data() + y * row);
  });
  return out;
}

/// Mixes pixels along rows. A row is laid out together with its continuation on both sides; the transpose
/// collects such a row, and adds the continuations to its ends.
template <std::floating_point T>
Array<T, 3> mixed_across(const Array<T, 3>& picture, const std::vector<double>& weights, bool is_transposed) {
  if (weights.size() == 1) return picture;
  const std::size_t taps = weights.size(), radius = taps / 2, channels = picture.shape(2);
  const std::size_t row = picture.shape(1) * channels, margin = radius * channels;
  Array<T, 3> out = xt::zeros_like(picture);
  for_each_row(picture.shape(0), [&](std::size_t y) {
    const T* const from = picture.data() + y * row;
    T* const to = out.data() + y * row;
    std::vector<T> wide(row + 2 * margin);
    if (is_transposed) {
      for (std::size_t tap = 0; tap < taps; ++tap)
        add_weighted(from, weights[tap], row, wide.data() + tap * channels);
      std::copy_n(wide.data() + margin, row, to);
      for (std::size_t x = 0; x < margin; ++x) {
        to[x % channels] += wide[x];
        to[row - channels + x % channels] += wide[margin + row + x];
      }
      return;
    }
    std::copy_n(from, row, wide.data() + margin);
    for (std::size_t x = 0; x < margin; ++x) {
      wide[x] = from[x % channels];
      wide[margin + row + x] = from[row - channels + x % channels];
    }
    for (std::size_t tap = 0; tap < taps; ++tap)
      add_weighted(wide.data() + tap * channels, weights[tap], row, to);
  });
  return out;
}

/// A number of mean 0 and variance 1 in ±2√3: the sum of four uniform ones, made from one word.
inline double near_normal(std::uint64_t bits) {
  const std::uint64_t sum =
      (bits & 0xFFFFU) + (bits >> 16U & 0xFFFFU) + (bits >> 32U & 0xFFFFU) + (bits >> 48U);
  return (static_cast<double>(sum) / 65536 - 2 + 2.0 / 65536) * 1.7320508075688772;
}

/// Calls visit(i, noise of variance 1) for every number of a picture, from several threads; the noise is the
/// same for the same seed.
template <class Visit>
void for_each_with_noise(const Extents<3>& extents, std::uint64_t seed, Visit visit) {
  const std::size_t row = extents[1] * extents[2];
  for_each_row(extents[0], [&](std::size_t y) {
    Random random = Random(seed).fork(y);
    for (std::size_t i = y * row; i < (y + 1) * row; ++i) visit(i, near_normal(random.bits()));
  });
}
}  // namespace detail

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

template <std::floating_point T>
Array<T, 3> transformed(const Array<T, 3>& picture, const SensorNoise& noise) {
  detail::require_sound(noise);
  Array<T, 3> out(picture.shape());
  const T shot = static_cast<T>(noise.shot), dark = static_cast<T>(noise.read * noise.read);
  detail::for_each_with_noise(picture.shape(), noise.seed, [&](std::size_t i, double normal) {
    const T value = picture.data()[i];
    out.data()[i] = value + std::sqrt(shot * std::max(value, T(0)) + dark) * static_cast<T>(normal);
  });
  return out;
}

template <std::floating_point T>
void transformed_adjoint(const Array<T, 3>& picture, const SensorNoise& noise, const Array<T, 3>& out_adjoint,
                         Array<T, 3>& picture_adjoint) {
  detail::require_sound(noise);
  require_shape("transformed_adjoint", "out_adjoint", out_adjoint, picture.shape());
  require_shape("transformed_adjoint", "picture_adjoint", picture_adjoint, picture.shape());
  const T shot = static_cast<T>(noise.shot), dark = static_cast<T>(noise.read * noise.read);
  detail::for_each_with_noise(picture.shape(), noise.seed, [&](std::size_t i, double normal) {
    const T value = picture.data()[i];
    const T slope =
        value > 0 ? 1 + static_cast<T>(normal) * shot / (2 * std::sqrt(shot * value + dark)) : T(1);
    picture_adjoint.data()[i] += slope * out_adjoint.data()[i];
  });
}
}  // namespace tapestry::image

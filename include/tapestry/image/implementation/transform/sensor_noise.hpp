#pragma once
#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/core/random.hpp>
#include <tapestry/image/transform/rows.hpp>
#include <tapestry/image/transform/sensor_noise.hpp>

namespace tapestry::image::detail {

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

void require_sound(const SensorNoise& noise) {
  if (!(noise.shot >= 0 && noise.read > 0))
    throw DomainError("sensor noise: shot must be at least 0 and read above 0");
}

}  // namespace tapestry::image::detail

namespace tapestry::image {

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

template Array<float, 3> transformed<float>(const Array<float, 3>& picture, const SensorNoise& noise);
template Array<double, 3> transformed<double>(const Array<double, 3>& picture, const SensorNoise& noise);
template void transformed_adjoint<float>(const Array<float, 3>& picture, const SensorNoise& noise,
                                         const Array<float, 3>& out_adjoint,
                                         Array<float, 3>& picture_adjoint);
template void transformed_adjoint<double>(const Array<double, 3>& picture, const SensorNoise& noise,
                                          const Array<double, 3>& out_adjoint,
                                          Array<double, 3>& picture_adjoint);

}  // namespace tapestry::image

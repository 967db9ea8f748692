#pragma once
#include <array>
#include <cmath>
#include <cstddef>
#include <numbers>
#include <tapestry/geometry/transform.hpp>

namespace tapestry::raster {

/// Nine numbers, one for each real spherical harmonic up to order 2, in the order (l, m) = (0, 0), (1, −1),
/// (1, 0), (1, 1), (2, −2) … (2, 2).
using Harmonics = std::array<double, 9>;

/// The spherical harmonics Y_lm at a direction of length 1, orthonormal over the sphere; z is the axis.
[[nodiscard]] inline Harmonics spherical_harmonics(const geometry::Vector3& direction) {
  const auto& [x, y, z] = direction;
  const double pi = std::numbers::pi;
  const double first = std::sqrt(3 / (4 * pi)), second = std::sqrt(15 / (4 * pi));
  return {std::sqrt(1 / (4 * pi)),
          first * y,
          first * z,
          first * x,
          second * x * y,
          second * y * z,
          second / std::sqrt(12.0) * (3 * z * z - 1),
          second * x * z,
          second / 2 * (x * x - y * y)};
}

/// What white paint with the normal n makes of a distant sky, by the sky's coefficients: ⟨result, sky⟩ =
/// E(n)/π, E being the irradiance of the radiance Σ sky_lm · Y_lm. So a sky of radiance 1 all around gives 1.
///
/// E = Σ A_l · sky_lm · Y_lm(n) with A = π, 2π/3, π/4, which is exact for skies of order 2, and for any other
/// within 3 % on average. Source: Ramamoorthi & Hanrahan, An Efficient Representation for Irradiance
/// Environment Maps (SIGGRAPH 2001), eqs. 8 and 9.
[[nodiscard]] inline Harmonics sky_transfer(const geometry::Vector3& normal) {
  Harmonics transfer = spherical_harmonics(normal);
  for (std::size_t i = 1; i < 9; ++i) transfer[i] *= i < 4 ? 2.0 / 3 : 1.0 / 4;
  return transfer;
}

/// Σ a·b
[[nodiscard]] inline double dot(const Harmonics& a, const Harmonics& b) {
  double sum = 0;
  for (std::size_t i = 0; i < 9; ++i) sum += a[i] * b[i];
  return sum;
}

/// A sky of the same radiance all around.
[[nodiscard]] inline Harmonics uniform_sky(double radiance) {
  return {radiance * std::sqrt(4 * std::numbers::pi), 0, 0, 0, 0, 0, 0, 0, 0};
}

/// Direction `index` of `count` that are spread evenly over the sphere, from above to below, along a spiral
/// of golden angles.
[[nodiscard]] inline geometry::Vector3 spiral_direction(std::size_t index, std::size_t count) {
  const double z = 1 - (2 * static_cast<double>(index) + 1) / static_cast<double>(count);
  const double across = std::sqrt(1 - z * z);
  const double turn = static_cast<double>(index) * std::numbers::pi * (3 - std::sqrt(5.0));
  return {across * std::cos(turn), across * std::sin(turn), z};
}

}  // namespace tapestry::raster

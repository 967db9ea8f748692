#pragma once
#include <concepts>
#include <cstdint>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>

namespace tapestry::image {

/// Noise of a camera's sensor, of variance shot · value + read². Source of the model: Foi et al., "Practical
/// Poissonian-Gaussian noise modeling and fitting for single-image raw-data" (2008), here for encoded values.
struct SensorNoise {
  double shot = 0;     ///< variance a unit of value
  double read = 0.01;  ///< standard deviation in the dark, above 0
  std::uint64_t seed = 1;
};

namespace detail {

void require_sound(const SensorNoise& noise);

}  // namespace detail

/// The picture with noise, not cut to 0 … 1.
///
/// \param picture  [H, W, C]; below 0 counts as 0 for the variance
/// \returns        [H, W, C]
/// \throws DomainError if shot is below 0 or read is not above it
template <std::floating_point T>
[[nodiscard]] Array<T, 3> transformed(const Array<T, 3>& picture, const SensorNoise& noise);

/// Adds the derivatives of transformed() to `picture_adjoint`; all are [H, W, C].
/// \throws ShapeError if extents differ, or as transformed()
template <std::floating_point T>
void transformed_adjoint(const Array<T, 3>& picture, const SensorNoise& noise, const Array<T, 3>& out_adjoint,
                         Array<T, 3>& picture_adjoint);

}  // namespace tapestry::image

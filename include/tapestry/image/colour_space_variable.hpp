#pragma once
#include <tapestry/autodiff/record.hpp>
#include <tapestry/core/compiled.hpp>
#include <tapestry/image/colour_space.hpp>

namespace tapestry::image {
/// linearised() of every value, on the tape.
template <std::floating_point T, std::size_t Rank>
[[nodiscard]] ArrayVariable<T, Rank> linearised(const ArrayVariable<T, Rank>& colours) {
  auto light = std::make_shared<const Array<T, Rank>>(linearised(colours.value()));
  const auto pullback = [encoded = colours.shared_value(), light](const Array<T, Rank>& light_adjoint,
                                                                  Array<T, Rank>* colours_adjoint) {
    parallel_for_vectors(light->size(),
                         detail::LinearisedPullback<T>{encoded->data(), light->data(), light_adjoint.data(),
                                                       colours_adjoint->data()});
  };
  return record_array(light, pullback, colours);
}

/// encoded() of every value, on the tape.
template <std::floating_point T, std::size_t Rank>
[[nodiscard]] ArrayVariable<T, Rank> encoded(const ArrayVariable<T, Rank>& light) {
  auto colours = std::make_shared<const Array<T, Rank>>(encoded(light.value()));
  const auto pullback = [linear = light.shared_value(), colours](const Array<T, Rank>& colours_adjoint,
                                                                 Array<T, Rank>* light_adjoint) {
    parallel_for_vectors(colours->size(), [&](std::size_t i) {
      light_adjoint->data()[i] +=
          colours_adjoint.data()[i] * encoded_slope(linear->data()[i], colours->data()[i]);
    });
  };
  return record_array(colours, pullback, light);
}

/// The same on a tape of duals.
template <DualNumber D, std::size_t Rank>
[[nodiscard]] ArrayVariable<D, Rank> linearised(const ArrayVariable<D, Rank>& colours) {
  const auto slope = []<class T>(T x) { return linearised_slope(x, linearised(x)); };
  const auto curvature = []<class T>(T x) {  // of the power c·(x + 0.055)^2.4
    return x <= T(detail::crossing_encoded) ? T(0)
                                            : T(1.4) * linearised_slope(x, linearised(x)) / (x + T(0.055));
  };
  return record_tangent(
      [=](const auto& x, const auto& along) {
        return std::pair(linearised(x), tangent_of_elements(x, along, slope, curvature));
      },
      colours);
}

/// The same on a tape of duals.
template <DualNumber D, std::size_t Rank>
[[nodiscard]] ArrayVariable<D, Rank> encoded(const ArrayVariable<D, Rank>& light) {
  const auto slope = []<class T>(T x) { return encoded_slope(x, encoded(x)); };
  const auto curvature = []<class T>(T x) {  // of the power c·x^(1/2.4)
    return x <= T(detail::crossing_linear) ? T(0) : (1 / T(2.4) - 1) * encoded_slope(x, encoded(x)) / x;
  };
  return record_tangent(
      [=](const auto& x, const auto& along) {
        return std::pair(encoded(x), tangent_of_elements(x, along, slope, curvature));
      },
      light);
}

// Texels and pictures; arrays of other ranks are compiled where they are used.
/// \cond
extern template ArrayVariable<float, 2> linearised<float, 2>(const ArrayVariable<float, 2>& colours);
extern template ArrayVariable<float, 3> linearised<float, 3>(const ArrayVariable<float, 3>& colours);
extern template ArrayVariable<double, 2> linearised<double, 2>(const ArrayVariable<double, 2>& colours);
extern template ArrayVariable<double, 3> linearised<double, 3>(const ArrayVariable<double, 3>& colours);
extern template ArrayVariable<float, 2> encoded<float, 2>(const ArrayVariable<float, 2>& light);
extern template ArrayVariable<float, 3> encoded<float, 3>(const ArrayVariable<float, 3>& light);
extern template ArrayVariable<double, 2> encoded<double, 2>(const ArrayVariable<double, 2>& light);
extern template ArrayVariable<double, 3> encoded<double, 3>(const ArrayVariable<double, 3>& light);
/// \endcond

/// Encoded colours converted to a space, on the tape.
template <Scalar T, std::size_t Rank>
[[nodiscard]] ArrayVariable<T, Rank> in_space(ColourSpace space, ArrayVariable<T, Rank> colours) {
  return space == ColourSpace::linear ? linearised(colours) : colours;
}
}  // namespace tapestry::image

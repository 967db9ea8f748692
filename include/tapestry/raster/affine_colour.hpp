#pragma once
#include <concepts>
#include <cstddef>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>

namespace tapestry::raster {
namespace detail {
template <std::floating_point T, std::size_t Rank>
void require_affine_colour(const char* operation, const Array<T, 3>& image, const Array<T, 2>& coverage,
                           const Array<T, Rank>& gain, const Array<T, Rank>& bias) {
  static_assert(Rank == 1 || Rank == 3, "gain and bias are [3] or [H, W, 3]");
  require_shape(operation, "image", image, {image.shape(0), image.shape(1), 3});
  require_shape(operation, "coverage", coverage, {image.shape(0), image.shape(1)});
  Extents<Rank> expected;
  for (std::size_t axis = 0; axis < Rank; ++axis) expected[axis] = image.shape(axis + 3 - Rank);
  require_shape(operation, "gain", gain, expected);
  require_shape(operation, "bias", bias, expected);
}
}  // namespace detail

/// Exposure, tint and haze of one view, to match a photograph: colour ← gain · colour + bias. For a render
/// the result is gain · P + bias · c, P being colour times coverage c, so that a pixel that shows nothing
/// stays empty.
///
/// \param image     P, [H, W, 3], as render() gives it
/// \param coverage  c, [H, W]
/// \param gain      [3], the same for all pixels, or [H, W, 3]
/// \param bias      as gain
/// \throws ShapeError if an argument does not fit the image
template <std::floating_point T, std::size_t Rank>
[[nodiscard]] Array<T, 3> affine_colour(const Array<T, 3>& image, const Array<T, 2>& coverage,
                                        const Array<T, Rank>& gain, const Array<T, Rank>& bias) {
  detail::require_affine_colour("affine_colour", image, coverage, gain, bias);
  Array<T, 3> result(image.shape());
  const std::size_t period = gain.size();
  for (std::size_t i = 0; i < image.size(); ++i)
    result.data()[i] =
        gain.data()[i % period] * image.data()[i] + bias.data()[i % period] * coverage.data()[i / 3];
  return result;
}

/// Adds the derivatives of affine_colour(); a null pointer stands for an argument that needs none.
///
/// \param affine_adjoint  [H, W, 3]; the adjoints have the extents of their arguments
/// \throws ShapeError as affine_colour()
template <std::floating_point T, std::size_t Rank>
void affine_colour_adjoint(const Array<T, 3>& image, const Array<T, 2>& coverage, const Array<T, Rank>& gain,
                           const Array<T, Rank>& bias, const Array<T, 3>& affine_adjoint,
                           Array<T, 3>* image_adjoint, Array<T, 2>* coverage_adjoint,
                           Array<T, Rank>* gain_adjoint, Array<T, Rank>* bias_adjoint) {
  detail::require_affine_colour("affine_colour_adjoint", image, coverage, gain, bias);
  require_shape("affine_colour_adjoint", "affine_adjoint", affine_adjoint, image.shape());
  const auto require = [](const char* argument, const auto* adjoint, const auto& of) {
    if (adjoint != nullptr) require_shape("affine_colour_adjoint", argument, *adjoint, of.shape());
  };
  require("image_adjoint", image_adjoint, image);
  require("coverage_adjoint", coverage_adjoint, coverage);
  require("gain_adjoint", gain_adjoint, gain);
  require("bias_adjoint", bias_adjoint, bias);
  const std::size_t period = gain.size();
  for (std::size_t i = 0; i < image.size(); ++i) {
    const T adjoint = affine_adjoint.data()[i];
    if (image_adjoint != nullptr) image_adjoint->data()[i] += gain.data()[i % period] * adjoint;
    if (coverage_adjoint != nullptr) coverage_adjoint->data()[i / 3] += bias.data()[i % period] * adjoint;
    if (gain_adjoint != nullptr) gain_adjoint->data()[i % period] += image.data()[i] * adjoint;
    if (bias_adjoint != nullptr) bias_adjoint->data()[i % period] += coverage.data()[i / 3] * adjoint;
  }
}

/// affine_colour() on the active tape; its pullback is affine_colour_adjoint(). Passive inputs record
/// nothing.
/// \throws ShapeError as affine_colour()
template <std::floating_point T, std::size_t Rank>
[[nodiscard]] ArrayVariable<T, 3> affine_colour(const ArrayVariable<T, 3>& image,
                                                const ArrayVariable<T, 2>& coverage,
                                                const ArrayVariable<T, Rank>& gain,
                                                const ArrayVariable<T, Rank>& bias) {
  const auto pullback = [i = image.shared_value(), c = coverage.shared_value(), g = gain.shared_value(),
                         b = bias.shared_value()](const Array<T, 3>& adjoint, auto*... inputs_adjoint) {
    affine_colour_adjoint(*i, *c, *g, *b, adjoint, inputs_adjoint...);
  };
  return record_array(affine_colour(image.value(), coverage.value(), gain.value(), bias.value()), pullback,
                      image, coverage, gain, bias);
}

}  // namespace tapestry::raster

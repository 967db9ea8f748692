#pragma once
#include <concepts>
#include <memory>
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/autodiff/variable.hpp>
#include <tapestry/camouflage/shape_parameter.hpp>
#include <tapestry/camouflage/view.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <vector>

namespace tapestry::camouflage {

/// Renders of the car in some views, on the tape.
template <std::floating_point T>
struct DrawnViews {
  std::vector<ArrayVariable<T, 3>> renders{};                   ///< m·O, multiplied by coverage
  std::vector<std::shared_ptr<const Array<T, 2>>> interiors{};  ///< as View::interior, of the renders
  std::vector<ArrayVariable<T, 3>> pictures{};  ///< I_adv, [H, W, 3], if drawn with the frame already
};

/// Draws the car as it stands, differentiable by its colours.
///
/// \param views    at least one, all of one car
/// \param colours  [texel, 3], encoded in either space
/// \throws DomainError for views in different colour spaces or of different pyramids
template <std::floating_point T>
[[nodiscard]] DrawnViews<T> drawn_views(ViewSpan<T> views, const ArrayVariable<T, 2>& colours);

/// Draws the car with its vertices moved, differentiable by colours and steps; see redrawn().
/// \param steps  of shape_steps()
template <std::floating_point T>
[[nodiscard]] DrawnViews<T> drawn_views(ViewSpan<T> views, const ArrayVariable<T, 2>& colours,
                                        const ShapeParameter& shape, const ArrayVariable<T, 2>& steps);

/// Lays the renders over the frames: picture_of() of each view, as a batch, [N, H, W, 3].
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 4> laid_over(ViewSpan<T> views, const DrawnViews<T>& drawn);

/// Mean over the views of loss::smoothness() of the renders, between encoded colours.
template <std::floating_point T>
[[nodiscard]] Variable<T> smoothness_of(ViewSpan<T> views, const DrawnViews<T>& drawn);

}  // namespace tapestry::camouflage

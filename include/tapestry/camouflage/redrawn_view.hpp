#pragma once
#include <concepts>
#include <memory>
#include <tapestry/camouflage/shape_parameter.hpp>
#include <tapestry/camouflage/view.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/raster/render_variable.hpp>

namespace tapestry::camouflage {

/// A view whose car has another shape, on the tape.
template <std::floating_point T>
struct RedrawnView {
  ArrayVariable<T, 3> render;                   ///< m·O, [H, W, 3], multiplied by its coverage m·c
  ArrayVariable<T, 3> picture;                  ///< I_adv, [H, W, 3], see picture_of()
  std::shared_ptr<const Array<T, 2>> interior;  ///< as View::interior, of the whole picture; held still
};

/// Draws a view anew, differentiable by texels and positions, right through silhouettes. The mask stays that
/// of the frame: where the car grows beyond it, it is cut off, and where it shrinks, the frame shows.
///
/// \param texels     [texel, 3], in the view's colour space
/// \param positions  [V, 3]
/// \throws DomainError if the view does not keep what it is drawn by, see sight_of(); else as
///         raster::render()
template <std::floating_point T>
[[nodiscard]] RedrawnView<T> redrawn(const View<T>& view, const ShapeParameter& shape,
                                     const ArrayVariable<T, 2>& texels, const ArrayVariable<T, 2>& positions);

}  // namespace tapestry::camouflage

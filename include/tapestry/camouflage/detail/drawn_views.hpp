#pragma once
#include <tapestry/camouflage/objective.hpp>

namespace tapestry::camouflage {
/// Renders of the car in some views, on the tape.
template <std::floating_point T>
struct DrawnViews {
  std::vector<ArrayVariable<T, 3>> renders{};                   ///< m·O, multiplied by coverage
  std::vector<std::shared_ptr<const Array<T, 2>>> interiors{};  ///< as View::interior, of the renders
  std::vector<ArrayVariable<T, 3>> pictures{};  ///< I_adv, [H, W, 3], if drawn with the frame already
};

/// The texels that views are drawn from, in their colour space and pyramid.
///
/// \param views    at least one, all of one car
/// \param colours  [texel, 3], encoded in either space
/// \throws DomainError for views in different colour spaces or of different pyramids
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 2> drawn_texels(ViewSpan<T> views, const ArrayVariable<T, 2>& colours);

/// Draws the car as it stands, or where its vertices move anew; see redrawn().
/// \param shape  null where the car's shape stays
template <std::floating_point T>
[[nodiscard]] DrawnViews<T> drawn_views(ViewSpan<T> views, const DrawnPaint<T>& paint,
                                        const ShapeParameter* shape);

/// Lays the renders over the frames: picture_of() of each view, as a batch, [N, H, W, 3].
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 4> laid_over(ViewSpan<T> views, const DrawnViews<T>& drawn);

/// Mean over the views of loss::smoothness() within their interiors, which are covered wholly: there the
/// pictures show the encoded render alone.
/// \param pictures  of laid_over()
template <std::floating_point T>
[[nodiscard]] Variable<T> smoothness_of(ViewSpan<T> views, const DrawnViews<T>& drawn,
                                        const ArrayVariable<T, 4>& pictures);
}  // namespace tapestry::camouflage

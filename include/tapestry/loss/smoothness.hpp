#pragma once
#include <concepts>
#include <memory>
#include <tapestry/loss/detail/neighbour_steps.hpp>
#include <utility>
#include <vector>

namespace tapestry::loss {
namespace detail {
struct SquaredStep {
  [[nodiscard]] double value(double step) const { return step * step; }
  [[nodiscard]] double slope(double step) const { return 2 * step; }
};
}  // namespace detail

/// Squared colour steps between neighbouring pixels, counted inside the vehicle mask.
///
///   L = Σ M[y,x] · ((O[y+1,x,c] − O[y,x,c])² + (O[y,x+1,c] − O[y,x,c])²)
///
/// over y < H−1, x < W−1 and all c. A sum, not a mean: L grows with resolution. Pixels outside M are
/// read only where a step from inside M ends on them. Source: Wang et al., FCA (AAAI 2022), eq. 5, there
/// without M and over the composited picture; its published program, like this, sums over the render inside
/// M.
///
/// \param render  O, [H, W, C], colour in [0, 1], row 0 at the top
/// \param mask    M, [H, W], 1 on the vehicle and 0 elsewhere
/// \returns       L in squared colour units, summed in double
/// \throws ShapeError if mask is not [H, W]
template <Image Render, Mask VehicleMask>
[[nodiscard]] auto smoothness(const Render& render, const VehicleMask& mask) {
  return static_cast<typename Render::value_type>(
      detail::picture_steps("smoothness", detail::SquaredStep{}, render, mask));
}

/// Adds loss_adjoint · ∂L/∂O to render_adjoint, [H, W, C]; arguments otherwise as in smoothness().
template <Image Render, Mask VehicleMask>
void smoothness_adjoint(const Render& render, const VehicleMask& mask,
                        typename Render::value_type loss_adjoint, Render& render_adjoint) {
  detail::picture_steps_adjoint("smoothness_adjoint", detail::SquaredStep{}, render, mask,
                                static_cast<double>(loss_adjoint), render_adjoint);
}

/// Squared colour steps between neighbouring texels of an atlas that are both in use.
///
///   L = Σ U[y,x]·U[y+1,x]·(C[y+1,x] − C[y,x])² + Σ U[y,x]·U[y,x+1]·(C[y,x+1] − C[y,x])²
///
/// summed over the colour channels too; texels that no painted face refers to have no part in it. Charts that
/// touch in the atlas count as neighbours, whether or not they do on the car.
///
/// \param texels  C, [H·W, channel], row by row from the top, colour in [0, 1]
/// \param used    U, [H, W], 1 where a painted face refers to the texel and 0 elsewhere, as
///                raster::used_texels() finds
/// \returns       L in squared colour units, summed in double
/// \throws ShapeError if texels has not H·W rows
template <Mask Texels, Mask UsedTexels>
[[nodiscard]] auto atlas_smoothness(const Texels& texels, const UsedTexels& used) {
  return static_cast<typename Texels::value_type>(
      detail::atlas_steps("atlas_smoothness", detail::SquaredStep{}, texels, used));
}

/// Adds loss_adjoint · ∂L/∂C to texels_adjoint; arguments otherwise as in atlas_smoothness().
template <Mask Texels, Mask UsedTexels>
void atlas_smoothness_adjoint(const Texels& texels, const UsedTexels& used,
                              typename Texels::value_type loss_adjoint, Texels& texels_adjoint) {
  detail::atlas_steps_adjoint("atlas_smoothness_adjoint", detail::SquaredStep{}, texels, used,
                              static_cast<double>(loss_adjoint), texels_adjoint);
}

/// smoothness() of a picture on the active tape; its pullback is smoothness_adjoint().
///
/// \param picture  [H, W, C]
/// \param mask     [H, W], copied unless moved
/// \throws ShapeError if mask is not [H, W]
template <std::floating_point T>
[[nodiscard]] Variable<T> smoothness(const ArrayVariable<T, 3>& picture, Array<T, 2> mask) {
  return detail::record_picture_steps("smoothness", detail::SquaredStep{}, picture, std::move(mask));
}

/// The sum over several pictures, which may differ in size, as one record. Sums are in double and in a fixed
/// order: the same bits for any number of threads.
///
/// \throws ShapeError if there are not as many masks as pictures, or one does not fit its picture
template <std::floating_point T>
[[nodiscard]] Variable<T> smoothness(const std::vector<ArrayVariable<T, 3>>& pictures, SharedMasks<T> masks) {
  return detail::record_picture_steps("smoothness", detail::SquaredStep{}, pictures, std::move(masks));
}

/// atlas_smoothness() of a texture on the active tape; its pullback is atlas_smoothness_adjoint().
///
/// \param texels  [H·W, channel]
/// \param used    [H, W], as raster::used_texels() gives it; shared, and not to be changed before the tape's
///                last reverse()
/// \throws ShapeError if texels has not H·W rows
template <std::floating_point T>
[[nodiscard]] Variable<T> atlas_smoothness(const ArrayVariable<T, 2>& texels,
                                           std::shared_ptr<const Array<T, 2>> used) {
  return detail::record_atlas_steps("atlas_smoothness", detail::SquaredStep{}, texels, std::move(used));
}

}  // namespace tapestry::loss

#pragma once
#include <concepts>
#include <memory>
#include <tapestry/loss/neighbour_steps_variable.hpp>
#include <tapestry/loss/smoothness.hpp>
#include <utility>
#include <vector>

namespace tapestry::loss {

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

#pragma once
#include <concepts>
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/camouflage/photo_session.hpp>

namespace tapestry::camouflage {

/// Photographs of a batch of pictures on the tape, [N, H, W, 3]: image::transformed() by the shots' chains.
/// Without a session they are returned unchanged.
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 4> photographed(const ArrayVariable<T, 4>& pictures,
                                               const PhotoSession* session);

}  // namespace tapestry::camouflage

#pragma once
#include <concepts>
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/segment/u2_net.hpp>

namespace tapestry::segment {

/// The mask of a picture on the tape: U2Net::forward(), whose pullback is U2Net::pull_back(). A passive
/// picture records nothing.
///
/// \param network  must outlive the tape's last reverse()
/// \param picture  [H, W, 3], RGB in [0, 1]
/// \returns        [H, W] in [0, 1]
/// \throws ShapeError, DomainError and NumericError as U2Net::forward()
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 2> mask(const U2Net<T>& network, const ArrayVariable<T, 3>& picture);

}  // namespace tapestry::segment

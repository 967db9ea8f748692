#pragma once
#include <concepts>
#include <memory>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/segment/u2_net.hpp>
#include <utility>

namespace tapestry::segment {

/// The mask of a picture on the tape: U2Net::forward(), whose pullback is U2Net::pull_back(). A passive
/// picture records nothing.
///
/// \param network  must outlive the tape's last reverse()
/// \param picture  [H, W, 3], RGB in [0, 1]
/// \returns        [H, W] in [0, 1]
/// \throws ShapeError, DomainError and NumericError as U2Net::forward()
template <std::floating_point T>
[[nodiscard]] ArrayVariable<T, 2> mask(const U2Net<T>& network, const ArrayVariable<T, 3>& picture) {
  auto pass = std::make_shared<U2NetPass<T>>();
  network.forward(picture.value(), *pass,
                  picture.is_active() ? nn::Mode::input_gradient : nn::Mode::inference);
  const auto pullback = [&network, pass](const Array<T, 2>& mask_adjoint, Array<T, 3>* picture_adjoint) {
    network.pull_back(*pass, mask_adjoint, *picture_adjoint);
  };
  return record_array(std::shared_ptr<const Array<T, 2>>(pass, &pass->mask), pullback, picture);
}

}  // namespace tapestry::segment

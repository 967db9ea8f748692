#pragma once
#include <concepts>
#include <memory>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/segment/u2_net.hpp>
#include <tapestry/segment/u2_net_variable.hpp>
#include <utility>

namespace tapestry::segment {

template <std::floating_point T>
ArrayVariable<T, 2> mask(const U2Net<T>& network, const ArrayVariable<T, 3>& picture) {
  auto pass = std::make_shared<U2NetPass<T>>();
  network.forward(picture.value(), *pass,
                  picture.is_active() ? nn::Mode::input_gradient : nn::Mode::inference);
  const auto pullback = [&network, pass](const Array<T, 2>& mask_adjoint, Array<T, 3>* picture_adjoint) {
    network.pull_back(*pass, mask_adjoint, *picture_adjoint);
  };
  return record_array(std::shared_ptr<const Array<T, 2>>(pass, &pass->mask), pullback, picture);
}

template decltype(mask<float>) mask<float>;
template decltype(mask<double>) mask<double>;

}  // namespace tapestry::segment

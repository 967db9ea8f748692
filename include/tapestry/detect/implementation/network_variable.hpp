#pragma once
#include <algorithm>
#include <concepts>
#include <memory>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/detect/detector_variable.hpp>
#include <tapestry/detect/network_variable.hpp>
#include <utility>
#include <vector>

namespace tapestry::detect {

template <std::floating_point T>
std::vector<ArrayVariable<T, 4>> forward(const Network<T>& network, const ArrayVariable<T, 4>& images,
                                         std::shared_ptr<Pass<T>> pass) {
  if (!pass) pass = std::make_shared<Pass<T>>();
  const auto detector = network.detector();
  auto logits = forward(*detector, images, pass);
  pass->ran_by = detector;  // which the record needs
  return logits;
}

template <std::floating_point T>
std::vector<ArrayVariable<T, 4>> forward_within(const Network<T>& network, const ArrayVariable<T, 4>& images,
                                                const std::vector<KeptPicture<T>*>& kept,
                                                std::shared_ptr<Pass<T>> pass) {
  if (!pass) pass = std::make_shared<Pass<T>>();
  const auto detector = network.detector();
  auto logits = forward_within(*detector, images, kept, pass);
  pass->ran_by = detector;
  return logits;
}

template <std::floating_point T>
std::vector<ArrayVariable<T, 4>> forward(Network<T>& network, const ArrayVariable<T, 4>& images,
                                         const ArrayVariable<T, 1>& parameters,
                                         std::shared_ptr<Pass<T>> pass) {
  require_shape("Detector::forward", "images", images.value(),
                {std::max<std::size_t>(1, images.value().shape(0)), network.input_height(),
                 network.input_width(), network.input_channels()});
  require_shape("forward", "parameters", parameters.value(), {network.layout().count});
  tapestry::detail::require_recordable<T>(images.link(), parameters.link());
  T* const own = network.parameters().data();
  for (const ParameterBlock& block : network.layout().blocks)
    if (!is_running_statistic(block.role))
      std::copy_n(parameters.value().data() + block.offset, block.count, own + block.offset);
  if (!pass) pass = std::make_shared<Pass<T>>();
  network.forward(images.value(), *pass, Mode::training);
  auto logits = detail::shared_logits(pass);
  const auto pullback = [&network, pass](const std::vector<const Array<T, 4>*>& logits_adjoint,
                                         Array<T, 4>* images_adjoint, Array<T, 1>* parameters_adjoint) {
    network.pull_back(*pass, logits_adjoint, images_adjoint, parameters_adjoint);
  };
  return record_shared_arrays<T, 4>(std::move(logits), pullback, images, parameters);
}

template std::vector<ArrayVariable<float, 4>> forward<float>(const Network<float>&,
                                                             const ArrayVariable<float, 4>&,
                                                             std::shared_ptr<Pass<float>>);
template std::vector<ArrayVariable<double, 4>> forward<double>(const Network<double>&,
                                                               const ArrayVariable<double, 4>&,
                                                               std::shared_ptr<Pass<double>>);
template std::vector<ArrayVariable<float, 4>> forward_within<float>(const Network<float>&,
                                                                    const ArrayVariable<float, 4>&,
                                                                    const std::vector<KeptPicture<float>*>&,
                                                                    std::shared_ptr<Pass<float>>);
template std::vector<ArrayVariable<double, 4>> forward_within<double>(
    const Network<double>&, const ArrayVariable<double, 4>&, const std::vector<KeptPicture<double>*>&,
    std::shared_ptr<Pass<double>>);
template std::vector<ArrayVariable<float, 4>> forward<float>(Network<float>&, const ArrayVariable<float, 4>&,
                                                             const ArrayVariable<float, 1>&,
                                                             std::shared_ptr<Pass<float>>);
template std::vector<ArrayVariable<double, 4>> forward<double>(Network<double>&,
                                                               const ArrayVariable<double, 4>&,
                                                               const ArrayVariable<double, 1>&,
                                                               std::shared_ptr<Pass<double>>);

}  // namespace tapestry::detect

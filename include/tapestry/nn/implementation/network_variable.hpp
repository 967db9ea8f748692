#pragma once
#include <algorithm>
#include <concepts>
#include <cstddef>
#include <memory>
#include <string>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/nn/buffer.hpp>
#include <tapestry/nn/network_variable.hpp>
#include <utility>
#include <vector>

namespace tapestry::nn::detail {

/// \throws ShapeError unless a tensor is one map or picture
[[nodiscard]] inline Extents<4> batch_of_maps(const char* what, const Shape& shape, std::size_t batch) {
  if (shape.size() != 4 || shape[0] != 1)
    throw ShapeError(std::string("nn::forward: ") + what + " of the network is " +
                     tapestry::detail::to_text(shape) + ", expected four axes, the first of extent 1");
  return {batch, shape[1], shape[2], shape[3]};
}

template <std::floating_point T>
void require_input(const Network<T>& network, const Array<T, 4>& x) {
  if (network.input_count() != 1)
    throw ShapeError("nn::forward: the network has " + std::to_string(network.input_count()) +
                     " inputs, expected one");
  if (x.shape(0) == 0) throw ShapeError("nn::forward: a batch of none");
  require_shape("nn::forward", "x", x, batch_of_maps("the input", network.input_shape(0), x.shape(0)));
  for (std::size_t i = 0; i < network.output_count(); ++i)
    static_cast<void>(batch_of_maps("a result", network.output_shape(i), 1));
}

/// \param weights  variables of the network's weights, or nothing
template <std::floating_point T, class... Weights>
[[nodiscard]] std::vector<ArrayVariable<T, 4>> record_network(const Network<T>& network, Mode mode,
                                                              std::shared_ptr<NetworkPass<T>> pass,
                                                              const ArrayVariable<T, 4>& x,
                                                              const Weights&... weights) {
  if (!pass) pass = std::make_shared<NetworkPass<T>>();
  const std::size_t batch = x.value().shape(0);
  const auto input = std::make_shared<Buffer<T>>(x.value().size());
  std::copy_n(x.value().data(), input->size(), input->data());
  network.forward({input->data()}, *pass, mode, batch);
  std::vector<Array<T, 4>> results;
  for (std::size_t i = 0; i < network.output_count(); ++i) {
    results.emplace_back(batch_of_maps("a result", network.output_shape(i), batch));
    std::copy_n(pass->output(i), results.back().size(), results.back().data());
  }
  const auto pullback = [&network, pass, input](const std::vector<const Array<T, 4>*>& adjoints,
                                                Array<T, 4>* x_adjoint, auto*... weights_adjoint) {
    std::vector<const T*> of_results;
    for (const auto* adjoint : adjoints) of_results.push_back(adjoint == nullptr ? nullptr : adjoint->data());
    T* of_weights = nullptr;
    ((of_weights = weights_adjoint == nullptr ? nullptr : weights_adjoint->data()), ...);
    network.adjoint(*pass, of_results, {x_adjoint == nullptr ? nullptr : x_adjoint->data()}, of_weights);
  };
  return record_arrays<T, 4>(std::move(results), pullback, x, weights...);
}

}  // namespace tapestry::nn::detail

namespace tapestry::nn {

template <std::floating_point T>
std::vector<ArrayVariable<T, 4>> forward(const Network<T>& network, const ArrayVariable<T, 4>& x,
                                         std::shared_ptr<NetworkPass<T>> pass) {
  detail::require_input(network, x.value());
  return detail::record_network(network, x.is_active() ? Mode::input_gradient : Mode::inference,
                                std::move(pass), x);
}

template <std::floating_point T>
std::vector<ArrayVariable<T, 4>> forward(Network<T>& network, const ArrayVariable<T, 4>& x,
                                         const ArrayVariable<T, 1>& weights,
                                         std::shared_ptr<NetworkPass<T>> pass) {
  detail::require_input(network, x.value());
  require_shape("nn::forward", "weights", weights.value(), {network.weights().size()});
  tapestry::detail::require_recordable<T>(x.link(), weights.link());
  network.set_weights({weights.value().data(), weights.value().size()});
  return detail::record_network(std::as_const(network), Mode::training, std::move(pass), x, weights);
}

template std::vector<ArrayVariable<float, 4>> forward<float>(const Network<float>&,
                                                             const ArrayVariable<float, 4>&,
                                                             std::shared_ptr<NetworkPass<float>>);
template std::vector<ArrayVariable<double, 4>> forward<double>(const Network<double>&,
                                                               const ArrayVariable<double, 4>&,
                                                               std::shared_ptr<NetworkPass<double>>);
template std::vector<ArrayVariable<float, 4>> forward<float>(Network<float>&, const ArrayVariable<float, 4>&,
                                                             const ArrayVariable<float, 1>&,
                                                             std::shared_ptr<NetworkPass<float>>);
template std::vector<ArrayVariable<double, 4>> forward<double>(Network<double>&,
                                                               const ArrayVariable<double, 4>&,
                                                               const ArrayVariable<double, 1>&,
                                                               std::shared_ptr<NetworkPass<double>>);

}  // namespace tapestry::nn

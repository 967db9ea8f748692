#pragma once
#include <concepts>
#include <memory>
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/nn/network/network.hpp>
#include <vector>

namespace tapestry::nn {

/// Results of a network of one input for a batch, as one record on the active tape.
///
/// \param network  whose input has four axes, the first of extent 1; must outlive the tape's last reverse(),
/// unchanged \param x        [N, …], N inputs as network.input_shape(0) says \param pass     memory to use,
/// for loops that record again and again: not to be used for anything else before the
///                 tape's last reverse(). Null takes new memory.
/// \returns        for each result of four axes, the first of extent 1, N of them
/// \throws ShapeError unless input, x and results are so; DomainError if x is on no active tape
template <std::floating_point T>
[[nodiscard]] std::vector<ArrayVariable<T, 4>> forward(const Network<T>& network,
                                                       const ArrayVariable<T, 4>& x,
                                                       std::shared_ptr<NetworkPass<T>> pass = nullptr);

/// The same in training mode, differentiable by the weights, too. The network takes over the weights'
/// values, which must stay until the tape's last reverse().
///
/// \param weights  in the order of network.weights()
/// \throws ShapeError also if there are not as many weights; whatever is thrown, they are not taken over
template <std::floating_point T>
[[nodiscard]] std::vector<ArrayVariable<T, 4>> forward(Network<T>& network, const ArrayVariable<T, 4>& x,
                                                       const ArrayVariable<T, 1>& weights,
                                                       std::shared_ptr<NetworkPass<T>> pass = nullptr);

}  // namespace tapestry::nn

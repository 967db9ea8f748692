#pragma once
#include <concepts>
#include <memory>
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/detect/kept_picture.hpp>
#include <tapestry/detect/network.hpp>
#include <vector>

namespace tapestry::detect {

/// forward() of the network's detector(); the network may change before the tape's last reverse().
template <std::floating_point T>
[[nodiscard]] std::vector<ArrayVariable<T, 4>> forward(const Network<T>& network,
                                                       const ArrayVariable<T, 4>& images,
                                                       std::shared_ptr<Pass<T>> pass = nullptr);

/// forward_within() of the network's detector().
template <std::floating_point T>
[[nodiscard]] std::vector<ArrayVariable<T, 4>> forward_within(const Network<T>& network,
                                                              const ArrayVariable<T, 4>& images,
                                                              const std::vector<KeptPicture<T>*>& kept,
                                                              std::shared_ptr<Pass<T>> pass = nullptr);

/// Logits in training mode, differentiable by the pictures and by the parameters: batch normalisation uses
/// the batch's statistics. The network takes over the parameters' values, which must stay until the tape's
/// last reverse(). Running statistics are state of the network, not parameters: their entries are neither
/// taken over nor given an adjoint; see Network::update_running_statistics().
///
/// \param parameters  [network.layout().count], in its order
/// \throws ShapeError also if there are not as many parameters; whatever is thrown, they are not taken over
template <std::floating_point T>
[[nodiscard]] std::vector<ArrayVariable<T, 4>> forward(Network<T>& network, const ArrayVariable<T, 4>& images,
                                                       const ArrayVariable<T, 1>& parameters,
                                                       std::shared_ptr<Pass<T>> pass = nullptr);

}  // namespace tapestry::detect

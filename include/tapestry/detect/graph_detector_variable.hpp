#pragma once
#include <concepts>
#include <memory>
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/detect/graph_detector.hpp>
#include <tapestry/detect/network_variable.hpp>
#include <vector>

namespace tapestry::detect {

/// Logits of a detector that is a graph, on the tape, differentiable by the pictures and by its weights.
/// Batch normalisation that the network holds keeps its running statistics.
///
/// The detector takes over the constants' values, which must stay until the tape's last reverse(). Those that
/// are no weights, see nn::Network::weights(), have the adjoint 0.
///
/// \param images     [N, H, W, 3], RGB in [0, 1]
/// \param constants  [detector.network().constants().size()], in its order
/// \param pass       as in forward() of a Detector
/// \throws ShapeError as Detector::forward(), and if there are not as many constants; whatever is thrown,
/// they
///         are not taken over
template <std::floating_point T>
[[nodiscard]] std::vector<ArrayVariable<T, 4>> forward(GraphDetector<T>& detector,
                                                       const ArrayVariable<T, 4>& images,
                                                       const ArrayVariable<T, 1>& constants,
                                                       std::shared_ptr<Pass<T>> pass = nullptr);

}  // namespace tapestry::detect

#pragma once
#include <concepts>
#include <memory>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/detect/graph_detector.hpp>
#include <tapestry/detect/network_variable.hpp>
#include <utility>
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
                                                       std::shared_ptr<Pass<T>> pass = nullptr) {
  detector.require_images(images.value());
  require_shape("forward", "constants", constants.value(), {detector.network().constants().size()});
  tapestry::detail::require_recordable<T>(images.link(), constants.link());
  detector.network().set_constants({constants.value().data(), constants.value().data() + constants.size()});
  if (!pass) pass = std::make_shared<Pass<T>>();
  detector.forward(images.value(), *pass, Mode::training);
  const auto pullback = [&detector, pass](const std::vector<const Array<T, 4>*>& logits_adjoint,
                                          Array<T, 4>* images_adjoint, Array<T, 1>* constants_adjoint) {
    detector.pull_back(*pass, logits_adjoint, images_adjoint, constants_adjoint);
  };
  return record_shared_arrays<T, 4>(detail::shared_logits(pass), pullback, images, constants);
}

}  // namespace tapestry::detect

#pragma once
#include <concepts>
#include <cstddef>
#include <memory>
#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/detect/detector.hpp>
#include <vector>

namespace tapestry::detect {

/// What a detector sees in a batch, and where from.
template <std::floating_point T>
struct ExplainedLogits {
  std::vector<ArrayVariable<T, 4>> logits;  ///< as forward() gives them
  std::vector<ArrayVariable<T, 2>> heat;    ///< [H, W] of a layer, one an image
};

/// Logits and, of each picture, the layer_cam() of the surest candidate of a class, over the first layer that
/// the detector tells, on the tape. The pullback of a map is that of the layer's values; what the score asks
/// of the layer is taken as constant, as programs with Grad-CAM do it, which is exact, off kinks, where the
/// network above the layer is piecewise linear.
///
/// \param detector  that tells a layer; must outlive the tape's last reverse(), unchanged
/// \param images    [N, H, W, 3], RGB in [0, 1]
/// \param pass      memory to use, as for forward()
/// \throws as forward(); DomainError if the detector tells no layer, or has no such class
template <std::floating_point T>
[[nodiscard]] ExplainedLogits<T> explained_forward(const Detector<T>& detector,
                                                   const ArrayVariable<T, 4>& images, std::size_t class_index,
                                                   std::shared_ptr<Pass<T>> pass = nullptr);

}  // namespace tapestry::detect

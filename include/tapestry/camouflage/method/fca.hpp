#pragma once
#include <concepts>
#include <tapestry/camouflage/method/method.hpp>

namespace tapestry::camouflage {

/// The whole painted body, each texel for itself.
///
/// Source: Wang et al., "FCA: Learning a 3D Full-coverage Vehicle Camouflage for Multi-view Physical
/// Adversarial Attack" (AAAI 2022), eq. 1 and Algorithm 1. Faithful: what is painted, by what parameter and
/// optimiser. The loss is whatever the objective says, for this as for all methods, so that designs are
/// compared and not losses.
///
/// The method rauca is the same texture in light that is transferred from the photographs, see photo_light():
/// Zhou et al., "RAUCA" (ICML 2024), section 3.2. Faithful: the render is multiplied by the light of its
/// photograph, and the loss −log(1 − max score) is our max_score. Simplified: where RAUCA learns a network
/// that predicts from the photograph what each pixel is multiplied by and what is added to it, sun and sky
/// are estimated from the car in it; they multiply, and nothing is added.
template <std::floating_point T>
[[nodiscard]] Method<T> fca() {
  return {};
}

}  // namespace tapestry::camouflage

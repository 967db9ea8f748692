#pragma once
#include <concepts>
#include <tapestry/camouflage/method/method.hpp>
#include <tapestry/raster/painted_mesh.hpp>

namespace tapestry::camouflage {

/// The whole body, each texel for itself, to scatter the detector's attention: what is minimised is
/// loss::attention() of a heat map, and smoothness as ever, not an adversarial loss.
///
/// Source: Wang et al., "Dual Attention Suppression Attack: Generate Adversarial Camouflage in Physical
/// World" (CVPR 2021), eq. 4 and 5, on the faces that FCA (AAAI 2022) compares with as DAS-full. Faithful:
/// the loss, by which score and layer are constants as in its published program. Simplified: the map is the
/// LayerCAM of the attacked detector's surest candidate, over the last layer that all its heads see, and not
/// the Grad-CAM of a classifier, since Grad-CAM shows next to nothing of a detector's score; the second term,
/// closeness to the edges of a content picture, which serves how people see it, is left out.
template <std::floating_point T>
[[nodiscard]] Method<T> das_full();

/// The same on roof, hood and doors only, which DAS selects by hand (309 faces of its car); the rest of the
/// car keeps its own colours. \throws as panel_texels()
template <std::floating_point T>
[[nodiscard]] Method<T> das(const raster::PaintedMesh& car);

}  // namespace tapestry::camouflage

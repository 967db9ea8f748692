#pragma once
#include <concepts>
#include <cstddef>
#include <memory>
#include <tapestry/camouflage/method/method.hpp>
#include <tapestry/camouflage/method/panels.hpp>
#include <tapestry/camouflage/own_colours.hpp>
#include <tapestry/raster/painted_mesh.hpp>
#include <utility>
#include <vector>

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
[[nodiscard]] Method<T> das_full() {
  Method<T> method;
  method.attention = 1;
  return method;
}

/// The same on roof, hood and doors only, which DAS selects by hand (309 faces of its car); the rest of the
/// car keeps its own colours. \throws as panel_texels()
template <std::floating_point T>
[[nodiscard]] Method<T> das(const raster::PaintedMesh& car) {
  Method<T> method = das_full<T>();
  const auto texels = panel_texels("das", car);
  std::vector<std::size_t> rows(car.layout.texel_count(car.mesh), Method<T>::unpainted);
  for (std::size_t row = 0; row < texels.size(); ++row) rows[texels[row].texel] = row;
  method.row_of_texel = std::make_shared<const std::vector<std::size_t>>(std::move(rows));
  method.row_count = texels.size();
  method.elsewhere = own_colours<T>(car);
  return method;
}

}  // namespace tapestry::camouflage

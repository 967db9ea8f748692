#pragma once
#include <algorithm>
#include <array>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <memory>
#include <tapestry/camouflage/method/method.hpp>
#include <tapestry/camouflage/method/panels.hpp>
#include <tapestry/camouflage/method/planar_patch.hpp>
#include <tapestry/camouflage/own_colours.hpp>
#include <tapestry/raster/painted_mesh.hpp>
#include <utility>
#include <vector>

namespace tapestry::camouflage::detail {

/// The largest upright square within the extents of a panel, about their middle.
struct PatchSquare {
  double left = std::numeric_limits<double>::max(), right = -std::numeric_limits<double>::max();
  double bottom = std::numeric_limits<double>::max(), top = -std::numeric_limits<double>::max();

  void reach(const PanelTexel& texel) {
    left = std::min(left, texel.right);
    right = std::max(right, texel.right);
    bottom = std::min(bottom, texel.up);
    top = std::max(top, texel.up);
  }
  /// Row and column shares in [0, 1] of a place in the picture; outside them, outside the square.
  [[nodiscard]] std::array<double, 2> operator()(const PanelTexel& texel) const {
    const double side = std::min(right - left, top - bottom);
    if (!(side > 0)) return {2, 2};
    return {0.5 - (texel.up - (top + bottom) / 2) / side, 0.5 + (texel.right - (left + right) / 2) / side};
  }
};

}  // namespace tapestry::camouflage::detail

namespace tapestry::camouflage {

template <std::floating_point T>
Method<T> planar_patch(const raster::PaintedMesh& car) {
  const auto texels = panel_texels("planar_patch", car);
  std::array<detail::PatchSquare, panel_count> squares{};
  for (const PanelTexel& texel : texels) squares[static_cast<std::size_t>(texel.panel)].reach(texel);
  const auto place_of = [&](const PanelTexel& texel) {
    return squares[static_cast<std::size_t>(texel.panel)](texel);
  };
  std::array<std::size_t, panel_count> sizes{};
  for (const PanelTexel& texel : texels)
    if (detail::is_inside(place_of(texel))) ++sizes[static_cast<std::size_t>(texel.panel)];
  const auto largest = static_cast<double>(*std::max_element(sizes.begin(), sizes.end()));
  if (largest == 0)
    throw Error(
        ErrorKind::mismatch,
        "the method planar_patch needs a panel of more than a line of texels; the atlas is too small");
  const auto edge = static_cast<std::size_t>(std::sqrt(largest));

  std::vector<std::size_t> rows(car.layout.texel_count(car.mesh), Method<T>::unpainted);
  const auto pixel = [&](double share) {
    return std::min(static_cast<std::size_t>(share * static_cast<double>(edge)), edge - 1);
  };
  for (const PanelTexel& texel : texels)
    if (const auto place = place_of(texel); detail::is_inside(place))
      rows[texel.texel] = pixel(place[0]) * edge + pixel(place[1]);
  Method<T> method;
  method.row_of_texel = std::make_shared<const std::vector<std::size_t>>(std::move(rows));
  method.row_count = edge * edge;
  method.elsewhere = own_colours<T>(car);
  return method;
}

template decltype(planar_patch<float>) planar_patch<float>;
template decltype(planar_patch<double>) planar_patch<double>;

}  // namespace tapestry::camouflage

#pragma once
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <string>
#include <tapestry/camouflage/method/method.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/raster/painted_mesh.hpp>
#include <vector>

namespace tapestry::camouflage {

/// The parts of a car that are nearly flat, large and seen from afar.
enum class Panel : std::uint8_t { roof, hood, left_doors, right_doors };
inline constexpr std::size_t panel_count = 4;

/// A texel of a panel, and where on the car it lies.
struct PanelTexel {
  std::size_t texel = 0;
  Panel panel = Panel::roof;
  /// In the panel as one sees it who looks at it, doors upright and the front of the car above roof and
  /// hood: the mesh's units, to the right and up.
  double right = 0, up = 0;
  std::array<double, 3> position{};  ///< in half lengths, half widths and heights of the painted faces
};

/// \throws DomainError naming the method unless the texture is an atlas
void require_atlas(const std::string& method, const raster::PaintedMesh& car);

/// The texels of a car's atlas on its roof, its hood and its doors, each once, in ascending order. A texel is
/// where its centre is, or for one on the rim of a chart the nearest point of a face there.
///
/// The panels are found by place and normal in the box around the painted faces, x to the front and z up, for
/// published face lists belong to one mesh: nearly level and on top, or in front and above the middle;
/// upright to the side, in the middle of the length and below windows.
///
/// \param method  whose error it is
/// \throws DomainError unless the texture is an atlas; Error (mismatch) if none of its faces is on a panel
[[nodiscard]] std::vector<PanelTexel> panel_texels(const std::string& method, const raster::PaintedMesh& car);

/// A method that paints these texels, each for itself, by the row of its place in the list; the rest of the
/// car keeps its own colours.
template <std::floating_point T>
[[nodiscard]] Method<T> paint_panels(const raster::PaintedMesh& car, const std::vector<PanelTexel>& texels);

}  // namespace tapestry::camouflage

#pragma once
#include <tapestry/camouflage/detail/method/method.hpp>

namespace tapestry::camouflage {
namespace detail {
/// The box around the painted faces. A place in it is (a, b, h): a from −1 at the rear to 1 at the front, b
/// from −1 on the right to 1 on the left, h from 0 below to 1 on top.
class PaintedBox {
 public:
  explicit PaintedBox(const raster::PaintedMesh& car) {
    std::vector<geometry::Vector3> corners;
    for (std::size_t face = 0; face < car.painted.size(); ++face)
      for (const std::int32_t corner : car.mesh.faces[face])
        if (car.painted[face] != 0) corners.push_back(car.mesh.positions[static_cast<std::size_t>(corner)]);
    bounds_ = geometry::bounds_of(corners);
  }
  [[nodiscard]] std::array<double, 3> operator()(const std::array<double, 3>& x) const {
    std::array<double, 3> place{};
    for (std::size_t k = 0; k < 3; ++k) {
      const double low = bounds_.low[k], high = bounds_.high[k];
      const double share = high > low ? (x[k] - low) / (high - low) : 0.5;
      place[k] = k == 2 ? share : 2 * share - 1;
    }
    return place;
  }

 private:
  geometry::Bounds bounds_{};
};

/// The panel at a place of the box, by a normal of any length and side.
[[nodiscard]] inline std::optional<Panel> panel_at(const std::array<double, 3>& place,
                                                   const std::array<double, 3>& normal) {
  const double length = hypot(normal[0], normal[1], normal[2]);
  const auto faces = [&](std::size_t axis) { return std::abs(normal[axis]) > std::sqrt(0.5) * length; };
  const auto [a, b, h] = place;
  if (faces(2) && h > 0.85 && std::abs(a) < 0.6) return Panel::roof;
  if (faces(2) && h > 0.35 && h < 0.85 && a > 0.35 && a < 0.95) return Panel::hood;
  if (faces(1) && h > 0.1 && h < 0.65 && std::abs(a) < 0.45 && std::abs(b) > 0.6)
    return b > 0 ? Panel::left_doors : Panel::right_doors;
  return {};
}

/// Place of a point of the mesh in a panel, to the right and up; see PanelTexel.
[[nodiscard]] inline std::array<double, 2> within_panel(Panel panel, const std::array<double, 3>& x) {
  if (panel == Panel::left_doors) return {-x[0], x[2]};
  if (panel == Panel::right_doors) return {x[0], x[2]};
  return {-x[1], x[0]};
}
}  // namespace detail

void require_atlas(const std::string& method, const raster::PaintedMesh& car) {
  if (!car.layout.traits().is_picture)
    throw DomainError({"the method ", method, " paints parts of an atlas, found a texture of another kind"});
}

std::vector<PanelTexel> panel_texels(const std::string& method, const raster::PaintedMesh& car) {
  require_atlas(method, car);
  const detail::PaintedBox box(car);
  std::vector<std::optional<PanelTexel>> found(car.layout.texel_count(car.mesh));
  for (const bool is_rim : {true, false})
    for (std::size_t face = 0; face < car.painted.size(); ++face) {
      if (car.painted[face] == 0) continue;
      std::array<std::array<double, 3>, 3> corner{};
      for (std::size_t k = 0; k < 3; ++k)
        for (std::size_t c = 0; c < 3; ++c)
          corner[k][c] = car.mesh.positions[static_cast<std::size_t>(car.mesh.faces[face][k])][c];
      const auto normal =
          geometry::cross(geometry::subtract(corner[1], corner[0]), geometry::subtract(corner[2], corner[0]));
      raster::for_each_atlas_texel(
          car.mesh, car.layout, face,
          [&](std::size_t row, std::size_t column, const std::array<double, 3>& weights) {
            if ((std::min({weights[0], weights[1], weights[2]}) < 0) != is_rim) return;
            const auto inside = raster::detail::clamped_barycentric(weights);
            std::array<double, 3> point{};
            for (std::size_t k = 0; k < 3; ++k)
              for (std::size_t c = 0; c < 3; ++c) point[c] += inside[k] * corner[k][c];
            const std::size_t texel = row * car.layout.width + column;
            const auto place = box(point);
            const auto panel = detail::panel_at(place, normal);
            found[texel].reset();
            if (!panel) return;
            const auto [right, up] = detail::within_panel(*panel, point);
            found[texel] = PanelTexel{texel, *panel, right, up, place};
          });
    }
  std::vector<PanelTexel> texels;
  for (const auto& texel : found)
    if (texel) texels.push_back(*texel);
  if (texels.empty())
    throw Error(ErrorKind::mismatch,
                {"the method ", method, " paints roof, hood and doors, of which no painted face is one"});
  return texels;
}
}  // namespace tapestry::camouflage

#pragma once
#include <tapestry/raster/estimated_light.hpp>

namespace tapestry::raster {

std::array<Tap, 4> EnvironmentMap::taps(const geometry::Vector3& direction) const {
  const double pi = std::numbers::pi, rows = static_cast<double>(height),
               columns = static_cast<double>(width);
  const double row =
      std::clamp(std::acos(std::clamp(direction[2], -1.0, 1.0)) / pi * rows - 0.5, 0.0, rows - 1);
  double column = std::atan2(direction[1], direction[0]) / (2 * pi) * columns - 0.5;
  if (column < 0) column += columns;
  const auto top = static_cast<std::size_t>(row), left = static_cast<std::size_t>(column) % width;
  const std::size_t below = std::min(top + 1, height - 1), right = (left + 1) % width;
  const double down = row - std::floor(row), across = column - std::floor(column);
  return {{{top * width + left, (1 - down) * (1 - across)},
           {top * width + right, (1 - down) * across},
           {below * width + left, down * (1 - across)},
           {below * width + right, down * across}}};
}

geometry::Vector3 EnvironmentMap::direction(std::size_t texel) const {
  const double polar =
      std::numbers::pi * (static_cast<double>(texel / width) + 0.5) / static_cast<double>(height);
  const double around =
      2 * std::numbers::pi * (static_cast<double>(texel % width) + 0.5) / static_cast<double>(width);
  return {std::sin(polar) * std::cos(around), std::sin(polar) * std::sin(around), std::cos(polar)};
}

std::array<double, 3> EnvironmentMap::at(const geometry::Vector3& direction) const {
  std::array<double, 3> sum{0, 0, 0};
  for (const Tap& tap : taps(direction))
    sum = geometry::add(sum, geometry::scale(texels[tap.texel], tap.weight));
  return sum;
}

CoatedPoint PreparedPhotographedLight::coat(std::size_t face, const std::array<double, 3>& b) const {
  return coated_point(normal(face, b), geometry::normalised(geometry::subtract(eye, point(face, b))));
}

std::array<double, 3> PreparedPhotographedLight::reflected(std::size_t face,
                                                           const std::array<double, 3>& b) const {
  if (!surroundings) return {0, 0, 0};
  const CoatedPoint seen = coat(face, b);
  return geometry::scale(surroundings->at(seen.mirrored), seen.fresnel * open_share(face, b));
}

PreparedPhotographedLight prepare(const geometry::Mesh& mesh, const geometry::Camera& camera,
                                  const PhotographedLight& light) {
  for (const auto& map : {light.surroundings, light.gloss}) {
    if (!map) continue;
    if (map->texels.empty()) throw DomainError("photographed light: the surroundings have no texels");
    if (map->height * map->width != map->texels.size())
      throw ShapeError({"photographed light: the surroundings have ", map->texels.size(),
                        " texels, expected ", map->height, " x ", map->width});
  }
  return {prepare(mesh, camera, static_cast<const OutdoorLight&>(light)), light, geometry::eye_of(camera),
          light.surroundings, light.gloss};
}

}  // namespace tapestry::raster

#pragma once
#include <array>
#include <cstddef>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/geometry/transform.hpp>
#include <tapestry/raster/clear_coat.hpp>
#include <tapestry/raster/fragments.hpp>
#include <tapestry/raster/lighting.hpp>
#include <tapestry/raster/outdoor_light.hpp>
#include <tapestry/raster/sky.hpp>

namespace tapestry::raster::detail {

/// (I − n·nᵀ) / |direction| · towards_adjoint: what a direction receives from its unit vector n.
[[nodiscard]] inline geometry::Vector3 through_length(const geometry::Vector3& direction,
                                                      const geometry::Vector3& towards_adjoint) {
  const geometry::Vector3 towards = geometry::normalised(direction);
  const double along = geometry::dot(towards_adjoint, towards);
  return geometry::scale(geometry::subtract(towards_adjoint, geometry::scale(towards, along)),
                         1 / geometry::length(direction));
}

/// Sums over fragments, in double.
struct LightSums {
  double ambient = 0, directional = 0;
  geometry::Vector3 towards{0, 0, 0};  ///< by the direction of length 1
  std::array<double, 3> colour{0, 0, 0};

  void add(const LightSums& other) {
    ambient += other.ambient;
    directional += other.directional;
    towards = geometry::add(towards, other.towards);
    colour = geometry::add(colour, other.colour);
  }

  [[nodiscard]] Light adjoint(const Light& light) const {
    return {ambient, directional, through_length(light.direction, towards), colour};
  }
};

/// Likewise, of an OutdoorLight.
struct OutdoorSums {
  double sun = 0;
  geometry::Vector3 towards{0, 0, 0};
  std::array<double, 3> colour{0, 0, 0};
  Harmonics sky{};

  void add(const OutdoorSums& other) {
    sun += other.sun;
    towards = geometry::add(towards, other.towards);
    colour = geometry::add(colour, other.colour);
    for (std::size_t i = 0; i < 9; ++i) sky[i] += other.sky[i];
  }

  [[nodiscard]] OutdoorLight adjoint(const OutdoorLight& light) const {
    return {sun, through_length(light.direction, towards), colour, sky, {}, {}};
  }
};

[[nodiscard]] inline LightSums no_sums(const Light&) { return {}; }
[[nodiscard]] inline OutdoorSums no_sums(const OutdoorLight&) { return {}; }

/// Adds a fragment's part.
/// \param factor  the light's, before its colour
/// \param seen    adjoint · coverage · colour before the light, of each channel; before it comes the same
///                without the colour, which only a coat needs
template <class Lighting>
void add_fragment(const Light& light, const Lighting& lighting, const geometry::Mesh& mesh,
                  const geometry::Vector3& eye, const Fragment& fragment, double factor,
                  const std::array<double, 3>&, const std::array<double, 3>& seen, LightSums& sums) {
  const geometry::Vector3 normal =
      lit_normal(lighting, mesh, eye, static_cast<std::size_t>(fragment.face), fragment.barycentric);
  const double s = geometry::dot(light.colour, seen),
               cosine = geometry::dot(normal, geometry::normalised(light.direction));
  sums.colour = geometry::add(sums.colour, geometry::scale(seen, factor));
  sums.ambient += s;
  if (!(cosine > 0)) return;
  sums.directional += s * cosine;
  sums.towards = geometry::add(sums.towards, geometry::scale(normal, s * light.directional));
}

/// Likewise, of an OutdoorLight.
inline void add_fragment(const OutdoorLight& light, const PreparedOutdoorLight& lighting,
                         const geometry::Mesh&, const geometry::Vector3&, const Fragment& fragment,
                         double factor, const std::array<double, 3>&, const std::array<double, 3>& seen,
                         OutdoorSums& sums) {
  const auto face = static_cast<std::size_t>(fragment.face);
  const auto& b = fragment.barycentric;
  const geometry::Vector3 normal = lighting.normal(face, b);
  const double s = geometry::dot(light.colour, seen);
  sums.colour = geometry::add(sums.colour, geometry::scale(seen, factor));
  const Harmonics transfer = sky_transfer(normal);
  if (dot(transfer, light.sky) > 0) {
    const double open = s * lighting.open_share(face, b);
    for (std::size_t i = 0; i < 9; ++i) sums.sky[i] += open * transfer[i];
  }
  const double cosine = geometry::dot(normal, lighting.towards);
  if (!(cosine > 0)) return;
  const double visible = s * lighting.visible_share(face, b);
  sums.sun += visible * cosine;
  sums.towards = geometry::add(sums.towards, geometry::scale(normal, visible * light.sun));
}

}  // namespace tapestry::raster::detail

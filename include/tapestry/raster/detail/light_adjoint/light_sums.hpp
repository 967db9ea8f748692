#pragma once
#include <tapestry/raster/clear_coat.hpp>
#include <tapestry/raster/fragments.hpp>

namespace tapestry::raster::detail {
/// (I − n·nᵀ) / |direction| · towards_adjoint: gradient of a direction, from that of its unit vector n.
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

/// The same for an OutdoorLight.
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
/// \param seen    adjoint · coverage · colour before the light, of each channel; the unnamed argument, for a
///                coat, lacks the colour
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

/// The same for an OutdoorLight.
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

/// Sums of a light with a ClearCoat, in double.
template <class Sums>
struct CoatSums {
  Sums base;
  double coat = 0, alpha = 0;

  void add(const CoatSums& other) {
    base.add(other.base);
    coat += other.coat;
    alpha += other.alpha;
  }

  template <class Base>
  [[nodiscard]] ClearCoat<Base> adjoint(const ClearCoat<Base>& light) const {
    return {Base{base.adjoint(light)}, coat, 2 * light.roughness * alpha};  // α = roughness²
  }
};

template <class Base>
[[nodiscard]] auto no_sums(const ClearCoat<Base>& light) {
  return CoatSums<decltype(no_sums(static_cast<const Base&>(light)))>{};
}

/// Adds the gradient that comes through the sun's mirror image.
/// \param by_sun      derivative of the loss by the sun
/// \param by_towards  and by its direction of length 1
inline void add_sun(double by_sun, const geometry::Vector3& by_towards, LightSums& sums) {
  sums.directional += by_sun;
  sums.towards = geometry::add(sums.towards, by_towards);
}
inline void add_sun(double by_sun, const geometry::Vector3& by_towards, OutdoorSums& sums) {
  sums.sun += by_sun;
  sums.towards = geometry::add(sums.towards, by_towards);
}

/// Adds the gradient that comes through the mirror image of the sky.
/// \param by_sky  derivative of the loss by the sky's radiance where it is mirrored
/// \returns       derivative of the radiance by alpha
inline double add_sky(double by_sky, const Light&, const geometry::Vector3&, double, LightSums& sums) {
  sums.ambient += by_sky;
  return 0;
}
inline double add_sky(double by_sky, const OutdoorLight& light, const geometry::Vector3& direction,
                      double alpha, OutdoorSums& sums) {
  const Harmonics mirrored = mirrored_harmonics(direction, alpha);
  if (!(dot(mirrored, light.sky) > 0)) return 0;
  double by_alpha = 0;
  for (std::size_t i = 0; i < 9; ++i) {
    sums.sky[i] += by_sky * mirrored[i];
    const double order = i == 0 ? 0 : i < 4 ? 1 : 2;
    by_alpha -= 2 * alpha * order * order * mirrored[i] * light.sky[i];
  }
  return by_alpha;
}

/// Adds the part of a fragment under a light with a ClearCoat.
template <class Base, class Sums>
void add_fragment(const ClearCoat<Base>& light, const PreparedClearCoat<Base>& lighting,
                  const geometry::Mesh& mesh, const geometry::Vector3& eye, const Fragment& fragment, double,
                  const std::array<double, 3>& covered, const std::array<double, 3>& seen,
                  CoatSums<Sums>& sums) {
  const auto face = static_cast<std::size_t>(fragment.face);
  const auto& b = fragment.barycentric;
  const CoatedPoint point = lighting.point(face, b);
  const double alpha = lighting.alpha(), factor = lighting.inner.at(face, b);
  add_fragment(static_cast<const Base&>(light), lighting.inner, mesh, eye, fragment, factor, covered,
               geometry::scale(seen, 1 - light.coat * point.fresnel), sums.base);

  const double covered_light = geometry::dot(light.colour, covered);  // ∂loss/∂(what is reflected)
  const auto sun =
      ggx_reflection(point.normal, point.to_eye, lighting.towards, point.n_dot_v, alpha, clear_coat_f0);
  const double visible = sun.value > 0 ? sun_share_of(lighting.inner, face, b) : 0;
  const double open = sky_share_of(lighting.inner, face, b) * point.fresnel;
  const double reflected =
      sun_of(light) * visible * sun.value + open * mirrored_sky(light, point.mirrored, alpha);
  const double by_sun = covered_light * light.coat * visible, by_sky = covered_light * light.coat * open;
  sums.base.colour = geometry::add(sums.base.colour, geometry::scale(covered, light.coat * reflected));
  sums.coat += covered_light * reflected - geometry::dot(light.colour, seen) * factor * point.fresnel;
  add_sun(by_sun * sun.value, geometry::scale(sun.by_towards, by_sun * sun_of(light)), sums.base);
  sums.alpha += by_sun * sun_of(light) * sun.by_alpha +
                by_sky * add_sky(by_sky, light, point.mirrored, alpha, sums.base);
}
}  // namespace tapestry::raster::detail

#pragma once
#include <tapestry/raster/outdoor_light.hpp>

namespace tapestry::raster {
/// Schlick's approximation of the mirrored share of light, f0 + (1 − f0)·(1 − cosine)⁵.
/// \param f0  the share at normal incidence
[[nodiscard]] inline double schlick_fresnel(double f0, double cosine) {
  const double grazing = 1 - cosine, squared = grazing * grazing;
  return f0 + (1 - f0) * squared * squared * grazing;
}

/// Density of the normals of microfacets by solid angle, D = α² / (π·q²) with q = sin² + α²·cos² of the angle
/// to the surface's normal; ∫ D·cos = 1 over the hemisphere. Source: Walter et al., Microfacet Models for
/// Refraction through Rough Surfaces (EGSR 2007), eq. 33, with the tangent written out.
/// \param alpha        its width, in (0, 1]
/// \param sine_square  sin², passed besides the cosine, since narrow lobes need all of its digits
[[nodiscard]] inline double ggx_density(double alpha, double cosine, double sine_square) {
  const double q = sine_square + alpha * alpha * cosine * cosine;
  return alpha * alpha / (std::numbers::pi * q * q);
}

/// Share of microfacets visible from both light and eye, over 4·(n·l)·(n·v):
///   V = ½ / ((n·l)·√((n·v)²(1 − α²) + α²) + (n·v)·√((n·l)²(1 − α²) + α²)).
/// Source: Heitz, Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs (JCGT 2014), eq. 99,
/// for GGX: masking and shadowing correlated by height.
[[nodiscard]] inline double ggx_visibility(double alpha, double n_dot_l, double n_dot_v) {
  const double a = alpha * alpha;
  return 0.5 / (n_dot_l * std::sqrt(n_dot_v * n_dot_v * (1 - a) + a) +
                n_dot_v * std::sqrt(n_dot_l * n_dot_l * (1 - a) + a));
}

/// Reflection of a distant light in a rough mirror, see ggx_reflection().
struct GgxReflection {
  double value = 0;
  double by_alpha = 0;
  geometry::Vector3 by_towards{0, 0, 0};  ///< derivative by l; its part along l has no meaning, as |l| = 1
};

/// π·D·V·F·(n·l) with D at the half vector h of l and v, F = schlick_fresnel(f0, h·v): the radiance towards
/// the eye from a light under which a white matt surface that faces it has the radiance 1. 0 where the light
/// is below the surface.
///
/// \param normal   n, of length 1
/// \param to_eye   v, of length 1
/// \param towards  l, to the light, of length 1
/// \param n_dot_v  the cosine at the eye, above 0 even where a blended normal turns away
[[nodiscard]] inline GgxReflection ggx_reflection(const geometry::Vector3& normal,
                                                  const geometry::Vector3& to_eye,
                                                  const geometry::Vector3& towards, double n_dot_v,
                                                  double alpha, double f0) {
  const double c = geometry::dot(normal, towards);
  const geometry::Vector3 sum = geometry::add(towards, to_eye);
  const double size = geometry::length(sum);  // 2·(h·v)
  if (!(c > 0) || !(size > 0)) return {};
  const geometry::Vector3 half = geometry::scale(sum, 1 / size);
  const geometry::Vector3 sine = geometry::cross(normal, half);
  const double cosine = geometry::dot(normal, half), sine_square = geometry::dot(sine, sine);
  const double a = alpha * alpha, q = sine_square + a * cosine * cosine;
  const double d = ggx_density(alpha, cosine, sine_square), v = ggx_visibility(alpha, c, n_dot_v);
  const double f = schlick_fresnel(f0, size / 2);
  const double value = std::numbers::pi * d * v * f * c;

  const double at_eye = std::sqrt(n_dot_v * n_dot_v * (1 - a) + a), at_light = std::sqrt(c * c * (1 - a) + a);
  const double density_by_alpha = 2 / alpha - 4 * alpha * cosine * cosine / q;  // ∂ ln D/∂α
  const double visibility_by_alpha =
      -2 * v * alpha * (c * (1 - n_dot_v * n_dot_v) / at_eye + n_dot_v * (1 - c * c) / at_light);
  const double by_cosine = 4 * cosine * (1 - a) / q;  // ∂ ln D/∂(n·h)
  const double by_c = 1 / c - 2 * v * (at_eye + n_dot_v * c * (1 - a) / at_light);
  const double by_half = -2.5 * (1 - f0) * std::pow(1 - size / 2, 4) / f;  // ∂ ln F/∂(h·v), halved
  const geometry::Vector3 turn =
      geometry::scale(geometry::subtract(normal, geometry::scale(half, cosine)), by_cosine / size);
  const geometry::Vector3 by_towards =
      geometry::add(geometry::add(turn, geometry::scale(normal, by_c)), geometry::scale(half, by_half));
  return {value, value * (density_by_alpha + visibility_by_alpha), geometry::scale(by_towards, value)};
}

/// A light, and a clear coat over all faces that mirrors it, as lacquer on a car does. With F = f0 + (1 − f0)
/// · (1 − n·v)⁵, f0 = 0.04 (glass), a colour shows as
///  (1 − coat·F) · (colour under Base)
///    + colour · coat · (sun · V · ggx_reflection() + F · A · (sky in the mirrored direction of v)).
/// The second part does not depend on texels, so the map from texture to picture stays linear, and its
/// derivative with respect to texels exact. Sun and sky are Base's: directional and ambient of Light and
/// SmoothLight; sun with its shadow V, and sky with its occlusion A, of OutdoorLight, whose harmonics of
/// order l a rough coat damps by exp(−(α·l)²). Colours should be linear: highlights are many times as bright
/// as paint.
///
/// Sources: the layers as in KHR_materials_clearcoat of glTF 2.0, α = roughness² as there; the damping is
/// that of Ramamoorthi & Hanrahan, A Signal-Processing Framework for Inverse Rendering (SIGGRAPH 2001).
/// \tparam Base  Light (flat), SmoothLight or OutdoorLight
template <class Base>
struct ClearCoat : Base {
  double coat = 1;         ///< share of the surface that is coated, in [0, 1]
  double roughness = 0.1;  ///< 0.01 (a mirror) to 1 (matt); at 0.06 highlights are as wide as the sun
};

/// The share that a clear coat mirrors at normal incidence: refractive index 1.5.
inline constexpr double clear_coat_f0 = 0.04;

/// The unit normal for the light at a point of a face.
[[nodiscard]] inline geometry::Vector3 lit_normal(const PreparedLight&, const geometry::Mesh& mesh,
                                                  const geometry::Vector3& eye, std::size_t face,
                                                  const std::array<double, 3>&) {
  return seen_normal(mesh, face, eye);
}

/// The same, interpolated over the face.
template <class Lighting>
[[nodiscard]] geometry::Vector3 lit_normal(const Lighting& lighting, const geometry::Mesh&,
                                           const geometry::Vector3&, std::size_t face,
                                           const std::array<double, 3>& b) {
  return lighting.normal(face, b);
}

namespace detail {
[[nodiscard]] inline double sun_of(const Light& light) { return light.directional; }
[[nodiscard]] inline double sun_of(const OutdoorLight& light) { return light.sun; }

/// The share of the sun that reaches a point, V.
template <class Lighting>
[[nodiscard]] double sun_share_of(const Lighting& lighting, std::size_t face,
                                  const std::array<double, 3>& b) {
  if constexpr (requires { lighting.visible_share(face, b); }) return lighting.visible_share(face, b);
  return 1;
}

/// The share of the sky visible from a point, A.
template <class Lighting>
[[nodiscard]] double sky_share_of(const Lighting& lighting, std::size_t face,
                                  const std::array<double, 3>& b) {
  if constexpr (requires { lighting.open_share(face, b); }) return lighting.open_share(face, b);
  return 1;
}

/// exp(−(α·l)²) · Y_lm: the weight of each harmonic of the sky in a rough mirror.
[[nodiscard]] inline Harmonics mirrored_harmonics(const geometry::Vector3& direction, double alpha) {
  Harmonics harmonics = spherical_harmonics(direction);
  const double first = std::exp(-alpha * alpha), second = std::exp(-4 * alpha * alpha);
  for (std::size_t i = 1; i < 9; ++i) harmonics[i] *= i < 4 ? first : second;
  return harmonics;
}

/// Radiance of the sky in a direction, blurred by a rough mirror.
[[nodiscard]] inline double mirrored_sky(const Light& light, const geometry::Vector3&, double) {
  return light.ambient;
}
[[nodiscard]] inline double mirrored_sky(const OutdoorLight& light, const geometry::Vector3& direction,
                                         double alpha) {
  return std::max(0.0, dot(mirrored_harmonics(direction, alpha), light.sky));
}
}  // namespace detail

/// A point of a coated surface, as the eye sees it.
struct CoatedPoint {
  geometry::Vector3 normal;    ///< n
  geometry::Vector3 to_eye;    ///< v, of length 1
  double n_dot_v;              ///< at least 0.001; its amount where a blended normal turns away
  geometry::Vector3 mirrored;  ///< 2·(n·v)·n − v, where the eye's ray goes on to
  double fresnel;              ///< F
};

/// A point of a coated surface.
/// \param normal  n, of length 1
/// \param to_eye  v, of length 1
[[nodiscard]] inline CoatedPoint coated_point(const geometry::Vector3& normal,
                                              const geometry::Vector3& to_eye) {
  CoatedPoint point{normal, to_eye, 0, {}, 0};
  const double cosine = geometry::dot(normal, to_eye);
  point.n_dot_v = std::clamp(std::abs(cosine), 0.001, 1.0);
  point.mirrored = geometry::subtract(geometry::scale(normal, 2 * cosine), to_eye);
  point.fresnel = schlick_fresnel(clear_coat_f0, point.n_dot_v);
  return point;
}

/// ClearCoat of one view.
template <class Base>
struct PreparedClearCoat {
  /// The type of prepare()'s result for the light without a coat.
  using Inner = decltype(prepare(std::declval<const geometry::Mesh&>(),
                                 std::declval<const geometry::Camera&>(), std::declval<const Base&>()));

  std::array<double, 3> light_colour;
  ClearCoat<Base> light;
  Inner inner;
  const geometry::Mesh* mesh;
  geometry::Vector3 eye;      ///< in the world
  geometry::Vector3 towards;  ///< the sun, of length 1

  [[nodiscard]] double alpha() const { return light.roughness * light.roughness; }

  [[nodiscard]] CoatedPoint point(std::size_t face, const std::array<double, 3>& b) const {
    geometry::Vector3 at{};
    for (std::size_t k = 0; k < 3; ++k)
      at = geometry::add(
          at, geometry::scale(mesh->positions[static_cast<std::size_t>(mesh->faces[face][k])], b[k]));
    return coated_point(lit_normal(inner, *mesh, eye, face, b),
                        geometry::normalised(geometry::subtract(eye, at)));
  }

  /// The base's factor, reduced by the mirrored share.
  [[nodiscard]] double at(std::size_t face, const std::array<double, 3>& b) const {
    return inner.at(face, b) * (1 - light.coat * point(face, b).fresnel);
  }

  /// Radiance that the coat adds, for any paint below it.
  [[nodiscard]] std::array<double, 3> reflected(std::size_t face, const std::array<double, 3>& b) const {
    const CoatedPoint seen = point(face, b);
    const double sun =
        ggx_reflection(seen.normal, seen.to_eye, towards, seen.n_dot_v, alpha(), clear_coat_f0).value;
    const double sky = seen.fresnel * detail::mirrored_sky(light, seen.mirrored, alpha());
    const double sum = detail::sun_of(light) * (sun > 0 ? detail::sun_share_of(inner, face, b) * sun : 0) +
                       detail::sky_share_of(inner, face, b) * sky;
    return geometry::scale(light_colour, light.coat * sum);
  }
};

/// \throws DomainError as the light without a coat, and for a coat or a roughness outside their ranges
template <class Base>
[[nodiscard]] PreparedClearCoat<Base> prepare(const geometry::Mesh& mesh, const geometry::Camera& camera,
                                              const ClearCoat<Base>& light) {
  const auto require = [](const char* name, double value, double least) {
    if (!(value >= least && value <= 1))
      throw DomainError({"clear coat: ", name, " is ", value, ", expected ", least, " to 1"});
  };
  require("coat", light.coat, 0);
  require("roughness", light.roughness, 0.01);
  auto inner = prepare(mesh, camera, static_cast<const Base&>(light));
  return {light.colour,
          light,
          std::move(inner),
          &mesh,
          geometry::eye_of(camera),
          geometry::normalised(light.direction)};
}
}  // namespace tapestry::raster

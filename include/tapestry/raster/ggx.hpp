#pragma once
#include <cmath>
#include <numbers>
#include <tapestry/geometry/transform.hpp>

namespace tapestry::raster {

/// Schlick's share of light that is mirrored at an angle, f0 + (1 − f0)·(1 − cosine)⁵.
/// \param f0  the share at normal incidence
[[nodiscard]] inline double schlick_fresnel(double f0, double cosine) {
  const double grazing = 1 - cosine, squared = grazing * grazing;
  return f0 + (1 - f0) * squared * squared * grazing;
}

/// Density of the normals of microfacets by solid angle, D = α² / (π·q²) with q = sin² + α²·cos² of the angle
/// to the surface's normal; ∫ D·cos = 1 over the hemisphere. Source: Walter et al., Microfacet Models for
/// Refraction through Rough Surfaces (EGSR 2007), eq. 33, with the tangent written out.
/// \param alpha        its width, in (0, 1]
/// \param sine_square  sin², apart from the cosine, for narrow lobes need all of its digits
[[nodiscard]] inline double ggx_density(double alpha, double cosine, double sine_square) {
  const double q = sine_square + alpha * alpha * cosine * cosine;
  return alpha * alpha / (std::numbers::pi * q * q);
}

/// Share of microfacets that both light and eye see, over 4·(n·l)·(n·v):
///   V = ½ / ((n·l)·√((n·v)²(1 − α²) + α²) + (n·v)·√((n·l)²(1 − α²) + α²)).
/// Source: Heitz, Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs (JCGT 2014), eq. 99,
/// for GGX: masking and shadowing correlated by height.
[[nodiscard]] inline double ggx_visibility(double alpha, double n_dot_l, double n_dot_v) {
  const double a = alpha * alpha;
  return 0.5 / (n_dot_l * std::sqrt(n_dot_v * n_dot_v * (1 - a) + a) +
                n_dot_v * std::sqrt(n_dot_l * n_dot_l * (1 - a) + a));
}

/// What of a distant light a rough mirror shows, see ggx_reflection().
struct GgxReflection {
  double value = 0;
  double by_alpha = 0;
  geometry::Vector3 by_towards{0, 0, 0};  ///< by l; the part along l means nothing, as l has length 1
};

/// π·D·V·F·(n·l) with D at the half vector h of l and v, F = schlick_fresnel(f0, h·v): the radiance that goes
/// to the eye from a light under which a white matt surface that faces it has the radiance 1. 0 where the
/// light is below the surface.
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

}  // namespace tapestry::raster

#pragma once
#include <tapestry/raster/clear_coat.hpp>
#include <tapestry/raster/detail/sky_basis.hpp>

namespace tapestry::raster {

/// Radiance from all directions, RGB. Texels [height, width]: rows from above, z = 1, to below, by even steps
/// of the angle to z; columns around z from +x towards +y. Bilinear between their centres.
struct EnvironmentMap {
  std::size_t height = 0;
  std::size_t width = 0;
  std::vector<std::array<double, 3>> texels;

  /// The texels of a lookup, whose weights sum to 1.
  /// \pre the map has texels, and the direction has length 1
  [[nodiscard]] std::array<Tap, 4> taps(const geometry::Vector3& direction) const;

  /// Direction of a texel's centre.
  [[nodiscard]] geometry::Vector3 direction(std::size_t texel) const;

  /// Radiance from a direction of length 1. Within half a row of z = ±1 it depends on the column alone.
  /// \pre as taps()
  [[nodiscard]] std::array<double, 3> at(const geometry::Vector3& direction) const;
};

/// Light that a photograph shows, for pictures laid over it:
///
///   painted    (1 − F) · colour · (OutdoorLight + A · gloss(m)) + F · A · surroundings(m)
///   unpainted  the photograph's own pixel
///
/// m is the mirrored direction of the eye, F schlick_fresnel(), A the open share of the sky. Gloss is light
/// that the paint mirrors in its own colour, as metallic paints do. The surroundings include the sun as the
/// coat mirrors it, and are as blurred as its roughness makes them. None of it depends on texels: the map
/// from texture to picture stays linear.
struct PhotographedLight : OutdoorLight, KeptPhotograph {
  std::shared_ptr<const EnvironmentMap> surroundings{};  ///< null: no coat, F = 0
  std::shared_ptr<const EnvironmentMap> gloss{};         ///< grey; null: the paint is matt below its coat
};

/// PhotographedLight of one view.
struct PreparedPhotographedLight : PreparedOutdoorLight, KeptPhotograph {
  geometry::Vector3 eye;  ///< in the world
  std::shared_ptr<const EnvironmentMap> surroundings, gloss;

  /// The coat at barycentric coordinates of a face.
  [[nodiscard]] CoatedPoint coat(std::size_t face, const std::array<double, 3>& b) const;

  [[nodiscard]] double at(std::size_t face, const std::array<double, 3>& b) const {
    double sum = PreparedOutdoorLight::at(face, b);
    if (!surroundings && !gloss) return sum;
    const CoatedPoint seen = coat(face, b);
    if (gloss) sum += open_share(face, b) * gloss->at(seen.mirrored)[0];
    return surroundings ? sum * (1 - seen.fresnel) : sum;
  }

  /// Radiance that the coat adds, for any paint below it.
  [[nodiscard]] std::array<double, 3> reflected(std::size_t face, const std::array<double, 3>& b) const;
};

/// \throws DomainError as for OutdoorLight, and for surroundings without texels; ShapeError unless those are
///         height · width
[[nodiscard]] PreparedPhotographedLight prepare(const geometry::Mesh& mesh, const geometry::Camera& camera,
                                                const PhotographedLight& light);

/// Result of estimated_light().
struct EstimatedLight {
  PhotographedLight light;  ///< for paint of reflectance 1; with the shadow of its sun, without occlusion
  std::array<double, 3> product{0, 0, 0};  ///< light colour times paint: the observed colour
  double error = 0;  ///< mean absolute difference from the photograph, over points and channels
};

/// The light of sun and sky that makes a surface of one colour look most like points of a photograph, by
/// least squares: sky and sun are not negative, the sun is above the horizon (+z), and both have one colour.
/// For a given sun the sky follows from the normal equations; the sun is searched for over directions. Points
/// far off, of trim, reflections and dirt, count less and less in four rounds.
///
/// A photograph shows light times paint, and nothing in it separates one from the other. With
/// `paint` the light gives such paint this look. Without `paint` it is white, and as strong as makes
/// white paint white where it is brightest (99th percentile of the points): the photograph is
/// assumed to be well exposed.
///
/// \param mesh          casts the shadows
/// \param points        of the photograph, of this mesh
/// \param paint         reflectance, RGB above 0, if it is known
/// \param shadow_pixels of the view from the sun
/// \throws DomainError without points, for paint that is not above 0, or for points that are not finite
[[nodiscard]] EstimatedLight estimated_light(const geometry::Mesh& mesh, const std::vector<LitPoint>& points,
                                             const std::optional<std::array<double, 3>>& paint = {},
                                             std::size_t shadow_pixels = 512);

/// The same light under a clear coat that mirrors the surroundings: sky, ground, buildings and the sun as the
/// paint itself shows them. Sky, sun, the observed colour, gloss and the surroundings are fitted in turn,
/// with the sun fixed at that of `matt`, gloss and surroundings from 4 × 8 to 64 × 128 texels. None is
/// negative, and the surroundings are at most twice as bright as white paint. Neighbouring texels are drawn
/// together where few points mirror them. Points weigh by the inverse of their differences, as encoded
/// colours; a channel at 1 is a bound, not a value.
///
/// \param points  with colours in proportion to light, and with the channels at 1 that estimated_light() is
///                not given
/// \param matt    estimated_light() of the other arguments, without paint or with this one
/// \param paint   as there
/// \throws DomainError as estimated_light(), and for a point without an eye
[[nodiscard]] EstimatedLight coated_light(const geometry::Mesh& mesh, const std::vector<LitPoint>& points,
                                          const EstimatedLight& matt,
                                          const std::optional<std::array<double, 3>>& paint = {});

}  // namespace tapestry::raster

#pragma once
#include <tapestry/raster/clear_coat.hpp>

namespace tapestry::raster {
inline constexpr std::size_t height_band_count = 4;         ///< of the sky's heights
using HeightBands = std::array<double, height_band_count>;  ///< one number a band

/// Shares of the heights 1/4, 1/2, 3/4 and 1 in a height of a direction of length 1: linear between them, 0
/// at the horizon and below.
[[nodiscard]] inline HeightBands height_bands(double height) {
  HeightBands bands;
  for (std::size_t k = 0; k < height_band_count; ++k)
    bands[k] = std::max(0.0, 1 - std::abs(height_band_count * height - static_cast<double>(k + 1)));
  return bands;
}

/// A coat without a colour: it mirrors all channels by one share, F = f0 + (1 − f0) · (1 − n·v)^exponent with
/// f0 = clear_coat_f0.
struct NeutralCoat {
  double exponent = 5;  ///< Schlick's; smaller ones stand for paints that darken earlier towards their edges
  Harmonics surroundings{};  ///< radiance that is mirrored, coefficients of spherical_harmonics()
  double glint = 0;          ///< strength of the sun in ggx_reflection(), with the width glint_alpha
  HeightBands bands{};       ///< radiance added to the surroundings by height, as above a skyline
};

/// Width of a coat's glint, α of GGX.
inline constexpr double glint_alpha = 0.4;

/// Light that photographs show, for pictures laid over them:
///
///   painted    (1 − F) · colour · OutdoorLight + light · (F · A · surroundings(m) + V · glint · GGX)
///   unpainted  the photograph's own pixel
///
/// m is the mirrored direction of the eye, F as in NeutralCoat, `light` the light's colour, A the open share
/// of the sky, V that of the sun. None of it depends on texels: the map from texture to picture stays linear.
struct PhotographedLight : OutdoorLight, KeptPhotograph {
  std::optional<NeutralCoat> coat{};  ///< none: F = 0
};

/// PhotographedLight of one view.
struct PreparedPhotographedLight : PreparedOutdoorLight, KeptPhotograph {
  geometry::Vector3 eye;  ///< in the world
  std::optional<NeutralCoat> coat;

  /// A point of the coat, with its F.
  [[nodiscard]] CoatedPoint coated(std::size_t face, const std::array<double, 3>& b) const;

  [[nodiscard]] double at(std::size_t face, const std::array<double, 3>& b) const {
    const double sum = PreparedOutdoorLight::at(face, b);
    return coat ? sum * (1 - coated(face, b).fresnel) : sum;
  }

  /// Radiance that the coat adds, for any paint below it.
  [[nodiscard]] std::array<double, 3> reflected(std::size_t face, const std::array<double, 3>& b) const;
};

/// \throws DomainError as for OutdoorLight
[[nodiscard]] PreparedPhotographedLight prepare(const geometry::Mesh& mesh, const geometry::Camera& camera,
                                                const PhotographedLight& light);

/// A point of a surface in a photograph.
struct LitPoint {
  std::size_t face = 0;
  geometry::Vector3 point{0, 0, 0};       ///< in the world
  geometry::Vector3 normal{0, 0, 1};      ///< of length 1, on the visible side
  double open = 1;                        ///< visible share of the sky, see AmbientOcclusion
  std::array<double, 3> colour{0, 0, 0};  ///< in the photograph, in proportion to light; at 1 it is a bound
  geometry::Vector3 to_eye{0, 0, 1};      ///< of length 1
  std::size_t view = 0;                   ///< number of its photograph
};

/// How a light does on photographs that it was not fitted to, each left out in turn. Errors as in
/// EstimatedLight, means over the photographs.
struct HeldOut {
  double error = 0;
  double error_of_all = 0;
  double sun_turn_rad = 0;  ///< largest angle between suns of these fits and of all photographs
  double sun_change = 0;    ///< largest relative difference of their strengths
};

/// Result of estimated_light().
struct EstimatedLight {
  PhotographedLight light;  ///< for paint of reflectance 1; with the shadow of its sun, without occlusion
  std::array<double, 3> product{0, 0, 0};  ///< light colour times paint: the observed colour
  /// Mean absolute difference from the photographs, over points of the paint and encoded channels.
  double error = 0;
  double error_of_all = 0;             ///< the same over all points, with those of other colours in these
  std::vector<std::uint8_t> others{};  ///< of faces: 0 paint, 1 a dark other colour, as trim, 2 a lighter one
  std::array<std::array<double, 3>, 2> other{};  ///< their observed colours, medians
  double other_share = 0;                        ///< share of points on them
  double sun_within_rad = 0;          ///< suns up to this angle away explain the points as well, within 1 %
  std::size_t views = 0;              ///< photographs it is fitted to
  std::optional<HeldOut> held_out{};  ///< none for a single photograph
};

/// Angle beyond which suns that explain photographs equally well leave the sun's direction unknown.
inline constexpr double unknown_sun_rad = 0.5;

/// The one light of sun and sky, under a neutral coat, that makes a surface of one colour look most like
/// points of photographs of one place and hour. For a given sun and exponent of the coat, all else follows by
/// least squares: the sun's strength, a sky and mirrored surroundings of order 2, their bands by height, the
/// glint, 24 numbers, and the observed colour. Direction and exponent are searched for, the sun above the
/// horizon (+z); the direction is the mean of those that explain the points about as well. Points weigh by
/// the inverse of their differences, as encoded colours: least absolute differences. A channel at 1 is a
/// bound.
///
/// Faces whose points have less than half of the paint's colour in them, with the coat taken off, are of
/// other colours, as trim is: the fit is repeated without them.
///
/// A photograph shows light times paint, and nothing in it separates one from the other. With `paint` the
/// light gives such paint this look. Without `paint` it is taken to be white, as that of a white-balanced
/// camera is, and as strong as makes white paint white where it is brightest (97th percentile of the points):
/// the photographs are assumed to be well exposed, and equally.
///
/// \param mesh          casts the shadows
/// \param points        of the photographs, of this mesh
/// \param paint         reflectance, RGB above 0, if it is known
/// \param shadow_pixels of the view from the sun
/// \throws DomainError without points, for paint that is not above 0, for points that are not finite or have
///         no eye
[[nodiscard]] EstimatedLight estimated_light(const geometry::Mesh& mesh, const std::vector<LitPoint>& points,
                                             const std::optional<std::array<double, 3>>& paint = {},
                                             std::size_t shadow_pixels = 512);
}  // namespace tapestry::raster

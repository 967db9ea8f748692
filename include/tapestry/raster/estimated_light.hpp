#pragma once
#include <array>
#include <cstddef>
#include <optional>
#include <tapestry/core/error.hpp>
#include <tapestry/geometry/mesh.hpp>
#include <tapestry/raster/light_equations.hpp>
#include <tapestry/raster/outdoor_light.hpp>
#include <vector>

namespace tapestry::raster {

/// What estimated_light() finds.
struct EstimatedLight {
  OutdoorLight light;  ///< for paint of reflectance 1; with the shadow of its sun, without occlusion
  std::array<double, 3> product{0, 0, 0};  ///< of the light's colour and the paint, which is what was seen
  double error = 0;  ///< mean absolute difference from the photograph, over points and channels
};

/// The light of sun and sky under which a surface of one colour looks most like points of a photograph, by
/// least squares: a sky that is nowhere negative, a sun that is not, above the horizon (+z), and one colour
/// for both. For a given sun the sky follows from the normal equations; the sun is searched for over
/// directions. Points far off, of trim, reflections and dirt, count less and less in four rounds.
///
/// A photograph shows light times paint, and nothing in it tells one from the other. With `paint` the light
/// is that which makes such paint look so. Without, it is white, and as strong as makes white paint white
/// where it is brightest (the 99th percentile of the points): the photograph is taken to be well exposed.
///
/// \param mesh          casts the shadows
/// \param points        of the photograph, of this mesh
/// \param paint         reflectance, RGB above 0, if it is known
/// \param shadow_pixels of the view from the sun
/// \throws DomainError without points, for paint that is not above 0, or for points that are not finite
[[nodiscard]] EstimatedLight estimated_light(const geometry::Mesh& mesh, const std::vector<LitPoint>& points,
                                             const std::optional<std::array<double, 3>>& paint = {},
                                             std::size_t shadow_pixels = 512);

}  // namespace tapestry::raster

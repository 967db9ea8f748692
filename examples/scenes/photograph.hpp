#pragma once
#include <tapestry/core/random.hpp>
#include "scene.hpp"

namespace tapestry::scenes {
/// Camera of photographs, and the places on their ground where a car may stand. Ranges are {low, high},
/// uniform.
struct PhotographOptions {
  double camera_height_m = 1.5;
  double pitch_deg = 0;  ///< of the camera, downwards
  double fov_deg = 60;   ///< horizontal
  std::pair<double, double> distance_m{5, 20};
  std::pair<double, double> yaw_rad{0, 6.283185307179586};  ///< of the car
};

/// Means of 2 × 2 pixels.
[[nodiscard]] Array<float, 3> halved(const Array<float, 3>& picture);

/// Horizontal field of view of a lens, degrees. Of 35 mm film, 36 × 24 mm, the diagonal counts (CIPA DC-008).
/// \param focal_length_35mm  mm
[[nodiscard]] inline double fov_of_lens_deg(double focal_length_35mm, double height, double width) {
  const double half_width = std::hypot(36, 24) / 2 * width / std::hypot(height, width);
  return 2 * std::atan(half_width / focal_length_35mm) * 180 / std::numbers::pi;
}

/// A photograph whose longer side has `size` pixels.
[[nodiscard]] Array<float, 3> resized_photograph(Array<float, 3> picture, std::size_t size);

/// The photograph's camera in the frame of a car. The car stands `ahead` metres before the camera, `left`
/// metres to its left, and is turned by `yaw` to the left of the direction of view.
[[nodiscard]] geometry::Camera photograph_camera(const PhotographOptions& options, double ahead, double left,
                                                 double yaw, double aspect);

/// Whether a vehicle lies in the picture as a whole from every side: for each of twelve headings at one of
/// twelve distances of the range, a little to the left and to the right of the middle.
/// \param aspect  of the photograph, width / height
[[nodiscard]] bool shows_whole_vehicle(const Vehicle& vehicle, const PhotographOptions& options,
                                       double aspect);

/// Encoded reflectance that a road is taken to have, grey: that of asphalt which some years have bleached.
/// New it returns .05 of the light, old up to .2, encoded .25 and .48. Source: Pomerantz et al., The Effect
/// of Pavements' Temperatures on Air Temperatures in Large Cities (LBNL-43442, 2000).
inline constexpr double asphalt = 0.45;

/// Median of each channel on the ground of a photograph, on rings around the car, [0, 1]; none where fewer
/// than twelve of 384 places lie in the picture.
/// \param camera                 in the frame of the car
/// \param nearest_m, farthest_m  radii of the first and the last ring
[[nodiscard]] std::optional<Colour> ground_colour(const Array<float, 3>& photograph,
                                                  const geometry::Camera& camera, double nearest_m,
                                                  double farthest_m);

/// The light where the car stands: strength and colour are those that give the ground around it, taken for
/// asphalt, its colours. Ground of under .6 of what lies around is in shade and has no sun. Direction and
/// share of the sun stay those given, as does the whole light where no ground is seen.
[[nodiscard]] raster::Light light_of_ground(raster::Light sun, const Array<float, 3>& photograph,
                                            const geometry::Camera& camera);

/// The user's vehicle on the ground of a photograph, in its light, with the shadow of some sun.
/// \param photograph  [H, W, 3], RGB in [0, 1]
[[nodiscard]] Scene make_scene_in_photograph(Random& random, Array<float, 3> photograph,
                                             const Vehicle& vehicle, const PhotographOptions& options);
}  // namespace tapestry::scenes

#pragma once
#include <tapestry/evaluate/views.hpp>
#include "../../../scenes/car.hpp"
#include "../../../scenes/scene.hpp"

namespace tapestry::shell {
/// Car length in the streets of protocols, which are in metres; half of it is the unit of distances.
inline constexpr double street_car_length_m = 4.6;

/// A street around the car, seen by a frame's camera.
inline scenes::SceneOptions street_options(const scenes::Vehicle& vehicle,
                                           const evaluate::ProtocolFrame& frame) {
  constexpr double rad_per_deg = std::numbers::pi / 180;
  const auto just = [](double value) { return std::pair(value, value); };
  scenes::SceneOptions options;
  options.vehicle = &vehicle;
  options.colour = scenes::CarOptions{}.colour;
  options.azimuth_rad = just(frame.azimuth_deg * rad_per_deg);
  options.elevation_deg = just(frame.elevation_deg);
  options.fov_deg = just(2 * evaluate::protocol_half_fov_deg);
  options.distance_m = just(frame.distance * street_car_length_m / 2);
  options.aim_jitter = options.occluder_chance = options.sensor_noise = 0;
  return options;
}

inline std::string name_of_view(const evaluate::ProtocolFrame& frame) {
  const auto number = evaluate::detail::short_number;
  return "distance " + number(frame.distance) + ", azimuth " + number(frame.azimuth_deg);
}
}  // namespace tapestry::shell

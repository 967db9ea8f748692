#pragma once
#include "car_shape.hpp"
#include "mesh_builder.hpp"

namespace tapestry::scenes {
struct CarOptions {
  BodyStyle style = BodyStyle::sedan;
  Colour colour{0.55F, 0.57F, 0.60F};      ///< of the material body
  std::array<double, 3> stretch{1, 1, 1};  ///< of length, width and height
  double spacing = 0.13;                   ///< between sections; metres; larger means fewer faces
};

/// A car, 4 to 5 m long, on the ground under the origin: x to the front, y to the left, z up; metres.
/// Materials: body (the paint, with uv), glass, tyre, light, tail_light, trim, rim, plate.
[[nodiscard]] geometry::Mesh make_car(const CarOptions& options);
}  // namespace tapestry::scenes

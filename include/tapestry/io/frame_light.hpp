#pragma once
#include <tapestry/image/colour_space.hpp>
#include <tapestry/io/frame.hpp>
#include <tapestry/raster/light.hpp>

namespace tapestry::io {

/// The light of a frame, for pictures in a colour space.
///
/// A frame states by which factors the numbers of its picture were multiplied where it was drawn; so does
/// Neural Mesh Renderer, whose light stands in where a frame states none. In ColourSpace::linear these become
/// what they stand for: white paint in the shade, and white paint that faces the light, look the same in both
/// spaces.
[[nodiscard]] inline raster::Light frame_light(const Frame& frame, image::ColourSpace space) {
  raster::Light light = frame.light.value_or(raster::Light{});
  if (space == image::ColourSpace::encoded) return light;
  const double brightest = image::linearised(light.ambient + light.directional);
  light.ambient = image::linearised(light.ambient);
  light.directional = brightest - light.ambient;
  for (double& channel : light.colour) channel = image::linearised(channel);
  return light;
}

}  // namespace tapestry::io

#pragma once
#include <tapestry/detect/box_overlap.hpp>
#include <tapestry/geometry/pose.hpp>
#include <tapestry/image/colour_space.hpp>
#include <tapestry/raster/light.hpp>

namespace tapestry::io {
/// A labelled object of a picture.
struct Label {
  std::size_t class_index = 0;
  detect::Box box{};  ///< pixels of the picture
};

/// One photographed or rendered view, with its camera, pose, light, mask and label where they are known.
struct Frame {
  std::string name;                         ///< for messages; a frame that was read has its path
  Array<std::uint8_t, 3> image;             ///< [H, W, 3], RGB
  std::optional<geometry::Camera> camera;   ///< of the picture, in the mesh's own units
  std::optional<geometry::CarlaPose> pose;  ///< of a simulator's frame; the car has length 2
  std::optional<raster::Light> light;
  std::optional<Array<std::uint8_t, 2>> mask;  ///< [H, W], non-zero where the car may show
  std::optional<Label> label;
  std::vector<std::string> warnings;  ///< unusual poses; never a reason to refuse the frame
};

/// The camera of a frame; for a simulator's frame it is computed from the pose.
/// \throws DomainError if the frame has neither
[[nodiscard]] inline geometry::Camera camera_of(const Frame& frame) {
  if (frame.camera) return *frame.camera;
  if (frame.pose) return geometry::carla_camera(*frame.pose);
  throw DomainError({"camera_of: frame ", frame.name, " has neither a camera nor a pose"});
}

/// The light of a frame, for pictures in a colour space.
///
/// A frame states the factors that its picture's values were multiplied by when drawn, as Neural Mesh
/// Renderer does. Without them that renderer's light is used. In ColourSpace::linear the factors are
/// converted so that two things look the same in both spaces: white paint in the shade, and white
/// paint that faces the light.
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

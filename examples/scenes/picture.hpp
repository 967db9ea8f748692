#pragma once
#include "scene.hpp"

namespace tapestry::scenes {
struct PictureBox {
  std::size_t class_index = 0;
  std::size_t object = 0;                           ///< index into the scene's objects
  double left = 0, top = 0, right = 0, bottom = 0;  ///< around its visible samples' pixels; pixels
  std::size_t visible_samples = 0;
  /// Visible area by the area of all faces turned to the camera, off the picture or hidden included:
  /// about 0.8 for a vehicle in full view, 1 for a convex thing.
  double visible_share = 0;
};

struct Picture {
  Array<float, 3> image;          ///< [H, W, 3], RGB in [0, 1]
  std::vector<PictureBox> boxes;  ///< of the objects that show at all
  Array<float, 2> car_mask;       ///< [H, W] share of the pixel that shows the main car, in [0, 1]
};

/// Draws a scene, 2×2 samples a pixel. The same scene gives the same picture.
[[nodiscard]] Picture draw_scene(const Scene& scene, std::size_t height, std::size_t width);
}  // namespace tapestry::scenes

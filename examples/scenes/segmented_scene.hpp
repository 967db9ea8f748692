#pragma once
#include <tapestry/core/random.hpp>
#include <tapestry/segment/car_component.hpp>
#include "scene.hpp"

namespace tapestry::scenes {
struct SegmentedScene {
  Array<std::uint8_t, 3> colours;  ///< [H, W, 3]
  Array<std::uint8_t, 2> car;      ///< [H, W] share of the pixel that shows the main car, of 255
  segment::Region box;             ///< around what shows of it
  double main_share = 0;           ///< its visible share, see PictureBox
};

[[nodiscard]] SegmentedScene draw_segmented(Random random, const SceneOptions& options, std::size_t size);

/// 1 where at least half of a pixel shows the car.
[[nodiscard]] Array<std::uint8_t, 2> silhouette_of(const SegmentedScene& scene);

/// Draws a scene to train on into one image of a batch, mirrored half the time and tinted.
/// \param images  [N, size, size, 3]
/// \param wanted  [N, size, size], share of the main car in [0, 1]
void put_segmented(Random random, std::size_t image, Array<float, 4>& images, Array<float, 3>& wanted);
}  // namespace tapestry::scenes

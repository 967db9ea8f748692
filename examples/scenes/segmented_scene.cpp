#include "segmented_scene.hpp"

#include "labelled_scene.hpp"
#include "make_scene.hpp"
#include "picture.hpp"

namespace tapestry::scenes {
SegmentedScene draw_segmented(Random random, const SceneOptions& options, std::size_t size) {
  const Scene scene = make_scene(random, options);
  const Picture picture = draw_scene(scene, size, size);
  SegmentedScene segmented;
  segmented.colours = image::to_bytes(picture.image);
  segmented.car.resize({size, size});
  for (std::size_t i = 0; i < segmented.car.size(); ++i)
    segmented.car.data()[i] = static_cast<std::uint8_t>(255 * picture.car_mask.data()[i] + 0.5F);
  for (const PictureBox& box : picture.boxes)
    if (box.object == scene.car_object) {
      segmented.box = {box.left, box.top, box.right, box.bottom};
      segmented.main_share = box.visible_share;
    }
  return segmented;
}

Array<std::uint8_t, 2> silhouette_of(const SegmentedScene& scene) {
  Array<std::uint8_t, 2> silhouette(scene.car.shape());
  for (std::size_t i = 0; i < silhouette.size(); ++i)
    silhouette.data()[i] = scene.car.data()[i] >= 128 ? 1 : 0;
  return silhouette;
}

void put_segmented(Random random, std::size_t image, Array<float, 4>& images, Array<float, 3>& wanted) {
  const std::size_t size = images.shape(1);
  const SegmentedScene scene = draw_segmented(random.fork(0), {}, size);
  const Variation variation = draw_variation(random);
  put_into_batch(scene.colours, image, variation, images);
  for (std::size_t row = 0; row < size; ++row)
    for (std::size_t column = 0; column < size; ++column) {
      const std::size_t from = variation.mirrored ? size - 1 - column : column;
      wanted(image, row, column) = static_cast<float>(scene.car(row, from)) / 255;
    }
}
}  // namespace tapestry::scenes

#include "labelled_scene.hpp"

#include "make_scene.hpp"
#include "picture.hpp"

namespace tapestry::scenes {
LabelledScene draw_labelled(Random random, const SceneOptions& options, std::size_t size) {
  const Scene scene = make_scene(random, options);
  const Picture picture = draw_scene(scene, size, size);
  LabelledScene labelled;
  labelled.colours = image::to_bytes(picture.image);
  for (const PictureBox& box : picture.boxes) {
    const loss::Target target{box.class_index,
                              detect::box_from_corners(box.left, box.top, box.right, box.bottom)};
    if (box.object == scene.car_object) {
      labelled.main = target;
      labelled.main_share = box.visible_share;
    }
    const bool shows = box.visible_share >= 0.25 && box.visible_samples >= 64;
    if (shows && std::min(target.box.w, target.box.h) >= 5) labelled.truths.push_back(target);
  }
  return labelled;
}

Variation draw_variation(Random& random) {
  Variation variation;
  variation.mirrored = random.chance(0.5);
  const double brightness = random.uniform(0.85, 1.15);
  for (float& channel : variation.gain) channel = static_cast<float>(brightness * random.uniform(0.94, 1.06));
  return variation;
}

std::vector<loss::Target> varied(std::vector<loss::Target> truths, const Variation& variation,
                                 std::size_t width) {
  if (variation.mirrored)
    for (loss::Target& truth : truths) truth.box.cx = static_cast<double>(width) - truth.box.cx;
  return truths;
}

void ScenePool::fill(std::size_t step, std::size_t fresh, Array<float, 4>& batch, loss::Truths& truths) {
  const std::size_t count = batch.shape(0);
  if (scenes_.size() < count) fresh = count;
  const std::size_t first_place = drawn_ % capacity_;
  if (scenes_.size() < capacity_) scenes_.resize(std::min(capacity_, scenes_.size() + fresh));
  parallel_for(fresh, [&](std::size_t i) {
    scenes_[(first_place + i) % capacity_] = draw_labelled(source_.fork(drawn_ + i), {}, size_);
  });
  drawn_ += fresh;
  Random random = source_.fork(~step);
  truths.assign(count, {});
  for (std::size_t image = 0; image < count; ++image) {
    const std::size_t place =
        image < fresh ? (first_place + image) % capacity_ : random.index(scenes_.size());
    const LabelledScene& scene = scenes_[place];
    const Variation variation = draw_variation(random);
    put_into_batch(scene.colours, image, variation, batch);
    truths[image] = varied(scene.truths, variation, size_);
  }
}
}  // namespace tapestry::scenes

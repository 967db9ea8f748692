#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <tapestry/core/array.hpp>
#include <tapestry/core/parallel.hpp>
#include <tapestry/core/random.hpp>
#include <tapestry/image/colour.hpp>
#include <tapestry/loss/yolo_training.hpp>
#include <utility>
#include <vector>

#include "make_scene.hpp"
#include "picture.hpp"

namespace tapestry::scenes {

/// A drawn scene as a detector sees it, small enough to keep thousands.
struct LabelledScene {
  Array<std::uint8_t, 3> colours;    ///< [H, W, 3]
  std::vector<loss::Target> truths;  ///< what shows well enough to be learned
  loss::Target main;                 ///< the main car, whether it is among the truths or not
  double main_share = 0;             ///< its visible share, see PictureBox
};

/// Draws a scene of `size` × `size` pixels and labels its objects. Left out as too hard to ask for: what
/// shows less than a quarter of itself, fewer than 16 pixels of area, or less than 5 pixels in one direction.
[[nodiscard]] inline LabelledScene draw_labelled(Random random, const SceneOptions& options,
                                                 std::size_t size) {
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

/// How a picture that is learned from differs from what was drawn: each channel times a gain, and perhaps
/// mirrored.
struct Variation {
  bool mirrored = false;
  Colour gain{1, 1, 1};
};

/// Mirrored half the time, brighter or darker by at most 15 %, tinted by at most 6 %.
[[nodiscard]] inline Variation draw_variation(Random& random) {
  Variation variation;
  variation.mirrored = random.chance(0.5);
  const double brightness = random.uniform(0.85, 1.15);
  for (float& channel : variation.gain) channel = static_cast<float>(brightness * random.uniform(0.94, 1.06));
  return variation;
}

/// Where objects lie in a varied picture of this width.
[[nodiscard]] inline std::vector<loss::Target> varied(std::vector<loss::Target> truths,
                                                      const Variation& variation, std::size_t width) {
  if (variation.mirrored)
    for (loss::Target& truth : truths) truth.box.cx = static_cast<double>(width) - truth.box.cx;
  return truths;
}

/// Writes a picture into one image of a batch [N, H, W, 3], at most 1.
/// \param values    of the picture, [H, W, 3]
/// \param value_of  makes a number in [0, 1] of each
template <class Value, class ValueOf>
void put_into_batch(const Value* values, ValueOf value_of, std::size_t image, const Variation& variation,
                    Array<float, 4>& batch) {
  const std::size_t height = batch.shape(1), width = batch.shape(2);
  for (std::size_t row = 0; row < height; ++row) {
    float* const out = batch.data() + 3 * (image * height + row) * width;
    const Value* const in = values + 3 * row * width;
    for (std::size_t column = 0; column < width; ++column) {
      const std::size_t from = variation.mirrored ? width - 1 - column : column;
      for (std::size_t c = 0; c < 3; ++c)
        out[3 * column + c] = std::min(1.0F, value_of(in[3 * from + c]) * variation.gain[c]);
    }
  }
}

/// Copies a scene into one image of a batch [N, size, size, 3].
inline void put_into_batch(const LabelledScene& scene, std::size_t image, const Variation& variation,
                           Array<float, 4>& batch) {
  put_into_batch(
      scene.colours.data(), [](std::uint8_t value) { return static_cast<float>(value) / 255; }, image,
      variation, batch);
}

/// The stream of training pictures: some of each batch are drawn anew, the rest come from the last ones
/// drawn, since drawing takes longer than learning. All are mirrored half the time and tinted. Everything
/// follows from the seed and the step.
class ScenePool {
 public:
  /// \param capacity  scenes kept, 3·size² bytes each
  ScenePool(std::uint64_t seed, std::size_t size, std::size_t capacity)
      : source_(seed), size_(size), capacity_(capacity) {}

  /// Draws `fresh` scenes, or as many as a first batch needs, and fills the batch with them and older ones.
  void fill(std::size_t step, std::size_t fresh, Array<float, 4>& batch, loss::Truths& truths) {
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
      put_into_batch(scene, image, variation, batch);
      truths[image] = varied(scene.truths, variation, size_);
    }
  }

 private:
  Random source_;
  std::size_t size_, capacity_, drawn_ = 0;
  std::vector<LabelledScene> scenes_;
};

}  // namespace tapestry::scenes

#pragma once
#include <tapestry/core/random.hpp>
#include <tapestry/loss/prediction.hpp>
#include "scene.hpp"

namespace tapestry::scenes {
/// A drawn scene as a detector sees it, small enough to keep thousands.
struct LabelledScene {
  Array<std::uint8_t, 3> colours;    ///< [H, W, 3]
  std::vector<loss::Target> truths;  ///< objects visible enough to be learned
  loss::Target main;                 ///< the main car, whether it is among the truths or not
  double main_share = 0;             ///< its visible share, see PictureBox
};

/// Draws a scene of `size` × `size` pixels and labels its objects. Objects that are too hard are left out:
/// less than a quarter of them shows, fewer than 16 pixels of area, or less than 5 pixels in one direction.
[[nodiscard]] LabelledScene draw_labelled(Random random, const SceneOptions& options, std::size_t size);

/// Changes of a training picture from the drawn one: a gain for each channel, and perhaps mirrored.
struct Variation {
  bool mirrored = false;
  Colour gain{1, 1, 1};
};

/// Mirrored half the time, brighter or darker by at most 15 %, tinted by at most 6 %.
[[nodiscard]] Variation draw_variation(Random& random);

/// Places of objects in a varied picture of this width.
[[nodiscard]] std::vector<loss::Target> varied(std::vector<loss::Target> truths, const Variation& variation,
                                               std::size_t width);

/// Writes a picture into one image of a batch [N, H, W, 3], at most 1.
/// \param picture  [H, W, 3], bytes or numbers in [0, 1]
template <class Value>
void put_into_batch(const Array<Value, 3>& picture, std::size_t image, const Variation& variation,
                    Array<float, 4>& batch) {
  constexpr float most = std::is_floating_point_v<Value> ? 1 : 255;
  const std::size_t height = batch.shape(1), width = batch.shape(2);
  for (std::size_t row = 0; row < height; ++row) {
    float* const out = batch.data() + 3 * (image * height + row) * width;
    const Value* const in = picture.data() + 3 * row * width;
    for (std::size_t column = 0; column < width; ++column) {
      const std::size_t from = variation.mirrored ? width - 1 - column : column;
      for (std::size_t c = 0; c < 3; ++c)
        out[3 * column + c] = std::min(1.0F, static_cast<float>(in[3 * from + c]) / most * variation.gain[c]);
    }
  }
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
  void fill(std::size_t step, std::size_t fresh, Array<float, 4>& batch, loss::Truths& truths);

 private:
  Random source_;
  std::size_t size_, capacity_, drawn_ = 0;
  std::vector<LabelledScene> scenes_;
};
}  // namespace tapestry::scenes

#pragma once
#include <tapestry/detect/head.hpp>
#include "random_array.hpp"

namespace tapestry::test {
/// Facts of a detector that losses need: three heads with strides 32, 16 and 8 for an input of 64 × 96
/// pixels, in Darknet's order; of two anchors, if the family has any, and the finest with scale_x_y 1.2.
class TinyHeads {
 public:
  static constexpr std::size_t classes = 3;

  explicit TinyHeads(detect::DecodeFamily decode = detect::DecodeFamily::darknet) {
    const auto add = [&](std::size_t stride, std::vector<std::array<double, 2>> anchors, double scale_x_y) {
      if (!detect::has_anchors(decode)) anchors.clear();
      heads_.push_back(
          {classes, input_height() / stride, input_width() / stride, std::move(anchors), scale_x_y, decode});
    };
    add(32, {{40, 30}, {60, 50}}, 1.0);
    add(16, {{20, 16}, {30, 30}}, 1.0);
    add(8, {{6, 6}, {9, 14}}, 1.2);
  }

  [[nodiscard]] const std::vector<detect::Head>& heads() const { return heads_; }
  [[nodiscard]] static std::size_t input_height() { return 64; }
  [[nodiscard]] static std::size_t input_width() { return 96; }

  /// Logits in [low, high) of a batch.
  template <class T>
  [[nodiscard]] std::vector<Array<T, 4>> logits(std::size_t images, std::uint64_t seed, double low = -1,
                                                double high = 1) const {
    std::vector<Array<T, 4>> logits;
    for (std::size_t i = 0; i < heads_.size(); ++i)
      logits.push_back(
          random_array<T>({images, heads_[i].channel_count(), heads_[i].grid_height, heads_[i].grid_width},
                          seed * 10 + i, low, high));
    return logits;
  }

  /// Logits of 0 of one picture.
  [[nodiscard]] std::vector<Array<double, 4>> flat_logits() const { return logits<double>(1, 1, 0, 0); }

 private:
  std::vector<detect::Head> heads_;
};
}  // namespace tapestry::test

#pragma once
#include <array>
#include <cstddef>
#include <tapestry/detect/decode_family.hpp>
#include <vector>

namespace tapestry::detect {

/// One output scale of a detector. Its logits are [N, A·(5+K), H, W], raw, before any sigmoid, but for the
/// decode family scaled, whose outputs are activations in [0, 1]; channel a·(5+K) + 0 … 3 is x, y, w, h of
/// anchor a, + 4 its objectness and + 5 + k its class k.
struct Head {
  std::size_t classes = 0;
  std::size_t grid_height = 0;
  std::size_t grid_width = 0;
  std::vector<std::array<double, 2>> anchors{};  ///< width, height in pixels of the network's input
  double scale_x_y = 1;
  DecodeFamily decode = DecodeFamily::darknet;

  /// A·(5+K), the channels of its logits.
  [[nodiscard]] std::size_t channel_count() const { return anchors.size() * (5 + classes); }
  /// The boxes that it proposes for a picture.
  [[nodiscard]] std::size_t candidate_count() const { return anchors.size() * grid_height * grid_width; }
};

}  // namespace tapestry::detect

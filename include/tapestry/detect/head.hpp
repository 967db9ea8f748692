#pragma once
#include <array>
#include <cstddef>
#include <string>
#include <tapestry/core/error.hpp>
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

/// \throws DomainError if a head has no class of that index
inline void require_class(const char* operation, const std::vector<Head>& heads, std::size_t class_index) {
  for (const Head& head : heads)
    if (class_index >= head.classes)
      throw DomainError(std::string(operation) + ": class " + std::to_string(class_index) +
                        " of a network with " + std::to_string(head.classes) + " classes");
}

}  // namespace tapestry::detect

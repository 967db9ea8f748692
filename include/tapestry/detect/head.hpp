#pragma once
#include <array>
#include <cstddef>
#include <optional>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/detect/decode_family.hpp>
#include <vector>

namespace tapestry::detect {

/// What a candidate of the decode family distance says first.
enum class ChannelOrder { box_first, classes_first };

/// The first channels of a candidate of every family but distance.
enum BoxChannel : std::size_t { x_channel, y_channel, w_channel, h_channel };

/// One output scale of a detector. Its logits are [N, A·D, H, W], raw, before any sigmoid or softmax, but for
/// the decode family scaled, whose outputs are activations in [0, 1]. Each of the A anchors has D channels, a
/// head without anchors A = 1:
///
///   family                                channels
///   darknet, ultralytics, scaled, yolox   x, y, w, h, objectness, K classes: D = 5 + K
///   distance, box first                   B bins each of left, top, right, bottom; K classes: D = 4·B + K
///   distance, classes first               K classes; B bins each of left, top, right, bottom
///   decoded                               x, y, w, h, K classes: D = 4 + K
struct Head {
  std::size_t classes = 0;
  std::size_t grid_height = 0;
  std::size_t grid_width = 0;
  std::vector<std::array<double, 2>> anchors{};  ///< width, height in pixels of the network's input
  double scale_x_y = 1;
  DecodeFamily decode = DecodeFamily::darknet;
  std::size_t bins = 8;                          ///< distance: B, for distances of 0 to B − 1 cells
  ChannelOrder order = ChannelOrder::box_first;  ///< distance
  std::size_t stride = 0;  ///< pixels between cells; 0: the input's extent over the grid's. It matters where
                           ///< the input is no multiple of it, so that the last cells reach over the border
  bool exclusive_classes = false;  ///< darknet: the classes' probabilities are a softmax, as in YOLOv2,
                                   ///< instead of one σ each

  /// A; a cell of a head without anchors has one candidate.
  [[nodiscard]] std::size_t anchor_count() const { return has_anchors(decode) ? anchors.size() : 1; }
  /// False for the families distance and decoded, where a class score says by itself that something is there.
  [[nodiscard]] bool has_objectness() const {
    return decode != DecodeFamily::distance && decode != DecodeFamily::decoded;
  }
  [[nodiscard]] std::size_t box_channel_count() const {
    return decode == DecodeFamily::distance ? 4 * bins : 4;
  }
  /// The first of a candidate's box_channel_count() channels that say where it is.
  [[nodiscard]] std::size_t box_channel() const { return has_classes_first() ? classes : 0; }
  [[nodiscard]] std::optional<std::size_t> objectness_channel() const {
    return has_objectness() ? std::optional(box_channel_count()) : std::nullopt;
  }
  [[nodiscard]] std::size_t class_channel(std::size_t class_index) const {
    if (has_classes_first()) return class_index;
    return box_channel_count() + (has_objectness() ? 1 : 0) + class_index;
  }
  /// D, the channels of one candidate.
  [[nodiscard]] std::size_t candidate_channel_count() const {
    return box_channel_count() + (has_objectness() ? 1 : 0) + classes;
  }
  /// A·D, the channels of its logits.
  [[nodiscard]] std::size_t channel_count() const { return anchor_count() * candidate_channel_count(); }
  /// The boxes that it proposes for a picture.
  [[nodiscard]] std::size_t candidate_count() const { return anchor_count() * grid_height * grid_width; }

 private:
  [[nodiscard]] bool has_classes_first() const {
    return decode == DecodeFamily::distance && order == ChannelOrder::classes_first;
  }
};

inline constexpr std::size_t largest_bin_count = 256;  ///< of a side of a box

/// \throws DomainError if a head of a family without anchors has some, one of the family distance no class
///         or not 1 to 256 bins, or one of another family than darknet exclusive classes
inline void require_layout(const char* operation, const Head& head) {
  const std::string of_family =
      std::string(operation) + ": a head of the decode family " + std::string(name_of(head.decode));
  if (!has_anchors(head.decode) && !head.anchors.empty())
    throw DomainError(of_family + " has " + std::to_string(head.anchors.size()) + " anchors, expected none");
  if (head.decode == DecodeFamily::distance && (head.bins == 0 || head.bins > largest_bin_count))
    throw DomainError(of_family + " has " + std::to_string(head.bins) + " bins, expected 1 to " +
                      std::to_string(largest_bin_count));
  if (!head.has_objectness() && head.classes == 0)
    throw DomainError(of_family + " has no classes, expected at least 1");
  if (head.exclusive_classes && head.decode != DecodeFamily::darknet)
    throw DomainError(of_family + " has exclusive classes, expected those of the family darknet alone");
}

/// \throws DomainError if a head has no class of that index
inline void require_class(const char* operation, const std::vector<Head>& heads, std::size_t class_index) {
  for (const Head& head : heads)
    if (class_index >= head.classes)
      throw DomainError(std::string(operation) + ": class " + std::to_string(class_index) +
                        " of a network with " + std::to_string(head.classes) + " classes");
}

}  // namespace tapestry::detect

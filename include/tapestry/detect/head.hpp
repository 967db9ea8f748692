#pragma once
#include <array>
#include <optional>
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <vector>

namespace tapestry::detect {
/// How a head's outputs become boxes and scores. Detectors of different families can have the same layers and
/// tensors, so the family must be stated: the wrong one puts every box elsewhere.
///
/// With the outputs t, the logistic function σ, and s the head's scale_x_y, for heads with anchors:
///
///   family       centre, in cells              extent, per anchor   score
///   darknet      (σ(t) − ½)·s + ½ + cell       e^t                  σ(objectness) · σ(class)
///   ultralytics  2·σ(t) − ½ + cell             (2·σ(t))²            σ(objectness) · σ(class)
///   scaled       t·s − (s − 1)/2 + cell        (2·t)²               objectness · class
///
/// and for heads without, which have one candidate a cell, all lengths in cells:
///
///   yolox        t + cell                      e^t                  σ(objectness) · σ(class)
///   distance     the box reaches Σ_b b·softmax(t)_b to the left of   σ(class)
///                cell + ½, and as far as three more such sums to its
///                top, right and bottom
///   decoded      t, in pixels                   max(0, t), in pixels  σ(class)
///
/// decoded is for exports that hold their own decoding; its cells are their candidates, in one row.
/// scaled is new_coords=1 of a cfg: t has been through σ already, in the convolution before the head, which
/// has activation=logistic. With s = 2 it puts boxes where ultralytics does for the logits before that σ.
/// The ultralytics family always has s = 2, and ignores a cfg's value. YOLOv2's [region] is darknet with s =
/// 1; its classes, and no others, can be exclusive: a softmax in the place of σ(class), see ClassScores.
///
/// Sources: darknet, Redmon and Farhadi, "YOLOv3" (2018), section 2.1, and for s Bochkovskiy et al., "YOLOv4"
/// (2020); ultralytics, the Detect layer of YOLOv5 and of its YOLOv3; scaled, Wang et al., "Scaled-YOLOv4"
/// (CVPR 2021), as new_coords in AlexeyAB's Darknet; yolox, Ge et al., "YOLOX" (2021); distance, Li et al.,
/// "Generalized Focal Loss" (NeurIPS 2020), as in NanoDet-m and in YOLOv8 and its successors.
enum class DecodeFamily { darknet, ultralytics, scaled, yolox, distance, decoded };

inline constexpr std::array<DecodeFamily, 6> decode_families{
    DecodeFamily::darknet, DecodeFamily::ultralytics, DecodeFamily::scaled,
    DecodeFamily::yolox,   DecodeFamily::distance,    DecodeFamily::decoded};

/// The families by name, for messages.
inline constexpr std::string_view decode_family_names =
    "darknet, ultralytics, scaled, yolox, distance or decoded";
/// Families with anchors, which a [yolo] section of a cfg may name.
inline constexpr std::string_view anchored_family_names = "darknet, ultralytics or scaled";

/// Whether boxes of a family are multiples of a head's anchors.
[[nodiscard]] constexpr bool has_anchors(DecodeFamily family) {
  return family == DecodeFamily::darknet || family == DecodeFamily::ultralytics ||
         family == DecodeFamily::scaled;
}

[[nodiscard]] constexpr std::string_view name_of(DecodeFamily family) {
  constexpr std::array<std::string_view, 6> names{"darknet", "ultralytics", "scaled",
                                                  "yolox",   "distance",    "decoded"};
  return names[static_cast<std::size_t>(family)];
}

/// \throws DomainError, naming all of them, for a name that no family has
[[nodiscard]] inline DecodeFamily decode_family_by_name(std::string_view name) {
  for (const DecodeFamily family : decode_families)
    if (name_of(family) == name) return family;
  throw DomainError({"no decode family is called ", in_quotes(name), "; expected ", decode_family_names});
}

/// Order of a candidate's channels in the decode family distance.
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
  /// False for the families distance and decoded, where the class score alone decides whether an object is
  /// there.
  [[nodiscard]] bool has_objectness() const {
    return decode != DecodeFamily::distance && decode != DecodeFamily::decoded;
  }
  [[nodiscard]] std::size_t box_channel_count() const {
    return decode == DecodeFamily::distance ? 4 * bins : 4;
  }
  /// The first of a candidate's box_channel_count() channels of the box.
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

/// \throws DomainError if a head of a family without anchors has some, a head of the family distance has no
///         class or not 1 to 256 bins, or a head outside the family darknet has exclusive classes
inline void require_layout(const char* operation, const Head& head) {
  const std::string of_family =
      std::string(operation) + ": a head of the decode family " + std::string(name_of(head.decode));
  if (!has_anchors(head.decode) && !head.anchors.empty())
    throw DomainError({of_family, " has ", head.anchors.size(), " anchors, expected none"});
  if (head.decode == DecodeFamily::distance && (head.bins == 0 || head.bins > largest_bin_count))
    throw DomainError({of_family, " has ", head.bins, " bins, expected 1 to ", largest_bin_count});
  if (!head.has_objectness() && head.classes == 0)
    throw DomainError({of_family, " has no classes, expected at least 1"});
  if (head.exclusive_classes && head.decode != DecodeFamily::darknet)
    throw DomainError({of_family, " has exclusive classes, expected those of the family darknet alone"});
}

/// \throws DomainError if a head has no class of that index
inline void require_class(const char* operation, const std::vector<Head>& heads, std::size_t class_index) {
  for (const Head& head : heads)
    if (class_index >= head.classes)
      throw DomainError(
          {operation, ": class ", class_index, " of a network with ", head.classes, " classes"});
}
}  // namespace tapestry::detect

#pragma once
#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>

namespace tapestry::detect {

/// How a head's outputs become boxes and scores. Detectors of different families can have the same layers and
/// tensors, so nothing but a word about it tells them apart, and the wrong family puts every box elsewhere.
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
/// The ultralytics family has 2 for s always, whatever a cfg says. YOLOv2's [region] is darknet with s = 1;
/// its classes, and no others, can be exclusive: a softmax in the place of σ(class), see ClassScores.
///
/// Sources: darknet, Redmon and Farhadi, "YOLOv3" (2018), section 2.1, and for s Bochkovskiy et al., "YOLOv4"
/// (2020); ultralytics, the Detect layer of YOLOv5 and of its YOLOv3; scaled, Wang et al.,
/// "Scaled-YOLOv4" (CVPR 2021), as new_coords in AlexeyAB's Darknet; yolox, Ge et al., "YOLOX" (2021);
/// distance, Li et al., "Generalized Focal Loss" (NeurIPS 2020), as in NanoDet-m and in YOLOv8 and its
/// successors.
enum class DecodeFamily { darknet, ultralytics, scaled, yolox, distance, decoded };

inline constexpr std::array<DecodeFamily, 6> decode_families{
    DecodeFamily::darknet, DecodeFamily::ultralytics, DecodeFamily::scaled,
    DecodeFamily::yolox,   DecodeFamily::distance,    DecodeFamily::decoded};

/// The families by name, for messages.
inline constexpr std::string_view decode_family_names =
    "darknet, ultralytics, scaled, yolox, distance or decoded";
/// Those with anchors, which are what a [yolo] section of a cfg can be of.
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
  throw DomainError("no decode family is called " + in_quotes(name) + "; expected " +
                    std::string(decode_family_names));
}

}  // namespace tapestry::detect

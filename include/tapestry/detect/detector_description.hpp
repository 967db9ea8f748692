#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/detect/decoded_outputs.hpp>
#include <tapestry/detect/head.hpp>
#include <tapestry/detect/input_encoding.hpp>
#include <tapestry/image/letterbox.hpp>
#include <vector>

namespace tapestry::detect {

/// The heads of known detectors: a decode family with what else of a Head is the same in all of them.
///
///   yolox    the decode family yolox
///   nanodet  the decode family distance, 8 bins, classes first: NanoDet-m
///   yolov8   the decode family distance, 16 bins, box first: YOLOv8 and its successors
///   yolov5   the decode family ultralytics, with YOLOv5's anchors for COCO unless there are others
///   boxes_and_scores  the decode family decoded, of an export that holds its own decoding
///
/// darknet and ultralytics are their decode families, with the anchors of a cfg or a description.
enum class HeadKind { darknet, ultralytics, yolox, nanodet, yolov8, yolov5, boxes_and_scores };

inline constexpr std::array<HeadKind, 7> head_kinds{
    HeadKind::darknet, HeadKind::ultralytics, HeadKind::yolox,           HeadKind::nanodet,
    HeadKind::yolov8,  HeadKind::yolov5,      HeadKind::boxes_and_scores};
/// The kinds by name, for messages.
inline constexpr std::string_view head_kind_names =
    "darknet, ultralytics, yolox, nanodet, yolov8, yolov5 or boxes_and_scores";

[[nodiscard]] constexpr std::string_view name_of(HeadKind kind) {
  constexpr std::array<std::string_view, 7> names{"darknet", "ultralytics", "yolox",           "nanodet",
                                                  "yolov8",  "yolov5",      "boxes_and_scores"};
  return names[static_cast<std::size_t>(kind)];
}

/// \throws DomainError, naming all of them, for a name that no kind has
[[nodiscard]] inline HeadKind head_kind_by_name(std::string_view name) {
  for (const HeadKind kind : head_kinds)
    if (name_of(kind) == name) return kind;
  throw DomainError("no kind of head is called " + in_quotes(name) + "; expected " +
                    std::string(head_kind_names));
}

[[nodiscard]] constexpr DecodeFamily decode_family_of(HeadKind kind) {
  if (kind == HeadKind::darknet) return DecodeFamily::darknet;
  if (kind == HeadKind::ultralytics || kind == HeadKind::yolov5) return DecodeFamily::ultralytics;
  if (kind == HeadKind::boxes_and_scores) return DecodeFamily::decoded;
  return kind == HeadKind::yolox ? DecodeFamily::yolox : DecodeFamily::distance;
}

/// What a file of a network's operators leaves open: how a picture goes in, and how its outputs become boxes.
struct DetectorDescription {
  InputEncoding encoding{};
  image::Fit fit{};
  HeadKind head = HeadKind::darknet;
  std::vector<std::size_t> strides{};  ///< pixels between cells, of each head in the order of the outputs
  /// Of each head with anchors, those of Head::anchors.
  std::vector<std::vector<std::array<double, 2>>> anchors{};
  DecodedOutputs decoded{};  ///< of boxes_and_scores, which has no strides

  bool operator==(const DetectorDescription&) const = default;
};

/// The description of a detector that is known by name: yolox, as Megvii's YOLOX takes its pictures since
/// version 0.1.1, nanodet, as NanoDet-m, or yolov5, as the models n to x of three grids.
/// Sources: Ge et al., "YOLOX" (2021) and its program; the configurations of NanoDet-m and of YOLOv5, version
/// 6, whose anchors they are.
/// \throws DomainError for any other name
[[nodiscard]] inline DetectorDescription known_description(std::string_view name) {
  if (name == "yolox")
    return {{ColourOrder::bgr, 1}, image::fit_by_name("letterbox_top_left"), HeadKind::yolox, {8, 16, 32}};
  if (name == "nanodet")
    return {{ColourOrder::bgr, 1, {103.53, 116.28, 123.675}, {57.375, 57.12, 58.395}},
            image::fit_by_name("stretch"),
            HeadKind::nanodet,
            {8, 16, 32}};
  if (name == "yolov5")
    return {{},
            {image::FitKind::letterbox, 114.0 / 255},
            HeadKind::yolov5,
            {8, 16, 32},
            {{{10, 13}, {16, 30}, {33, 23}},
             {{30, 61}, {62, 45}, {59, 119}},
             {{116, 90}, {156, 198}, {373, 326}}}};
  throw DomainError("no known detector is called " + in_quotes(name) + "; expected yolox, nanodet or yolov5");
}

/// The heads that a description means, for an input of the given extents: of each stride s one with
/// ⌈height / s⌉ × ⌈width / s⌉ cells. Of boxes_and_scores, which has no strides, there are none.
///
/// \param classes  K
/// \throws DomainError for a stride of 0, for heads with anchors unless each stride has some, and for anchors
///         of heads that take none
[[nodiscard]] inline std::vector<Head> heads_of(const DetectorDescription& description, std::size_t classes,
                                                std::size_t input_height, std::size_t input_width) {
  Head head;
  head.classes = classes;
  head.decode = decode_family_of(description.head);
  const std::size_t anchored = has_anchors(head.decode) ? description.strides.size() : 0;
  const auto is_none = [](const auto& anchors) { return anchors.empty(); };
  if (description.anchors.size() != anchored || std::ranges::any_of(description.anchors, is_none))
    throw DomainError("heads_of: a description of " + std::string(name_of(description.head)) +
                      " heads has anchors for " + std::to_string(description.anchors.size()) +
                      " of them, expected some for " + std::to_string(anchored));
  if (description.head == HeadKind::nanodet) head.order = ChannelOrder::classes_first;
  if (description.head == HeadKind::yolov8) head.bins = 16;
  std::vector<Head> heads;
  for (const std::size_t stride : description.strides) {
    if (stride == 0) throw DomainError("heads_of: a stride is 0, expected at least 1 pixel");
    head.stride = stride;
    head.grid_height = (input_height + stride - 1) / stride;
    head.grid_width = (input_width + stride - 1) / stride;
    if (anchored > 0) head.anchors = description.anchors[heads.size()];
    heads.push_back(head);
  }
  return heads;
}

/// K of the first head, which has so many channels.
/// \throws ShapeError if the channels leave no class, or not as many for each anchor; DomainError as
/// heads_of()
[[nodiscard]] inline std::size_t class_count_of(const DetectorDescription& description,
                                                std::size_t channels) {
  DetectorDescription one = description;
  one.strides = {1};
  if (one.anchors.size() > 1) one.anchors.resize(1);
  const Head head = heads_of(one, 0, 1, 1).front();
  const std::size_t others = head.channel_count(), candidates = head.anchor_count();
  if (channels <= others || channels % candidates != 0)
    throw ShapeError("class_count_of: outputs of " + std::to_string(channels) +
                     " channels, expected more than " + std::to_string(others) +
                     (candidates > 1 ? " and a multiple of " + std::to_string(candidates) : "") + " for " +
                     std::string(name_of(description.head)) + " heads");
  return (channels - others) / candidates;
}

}  // namespace tapestry::detect

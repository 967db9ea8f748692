#pragma once
#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>
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
///
/// darknet and ultralytics have anchors, which are not part of a description but of a cfg.
enum class HeadKind { darknet, ultralytics, yolox, nanodet, yolov8 };

inline constexpr std::array<HeadKind, 5> head_kinds{HeadKind::darknet, HeadKind::ultralytics, HeadKind::yolox,
                                                    HeadKind::nanodet, HeadKind::yolov8};
/// The kinds by name, for messages.
inline constexpr std::string_view head_kind_names = "darknet, ultralytics, yolox, nanodet or yolov8";

[[nodiscard]] constexpr std::string_view name_of(HeadKind kind) {
  constexpr std::array<std::string_view, 5> names{"darknet", "ultralytics", "yolox", "nanodet", "yolov8"};
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
  if (kind == HeadKind::ultralytics) return DecodeFamily::ultralytics;
  return kind == HeadKind::yolox ? DecodeFamily::yolox : DecodeFamily::distance;
}

/// What a file of a network's operators leaves open: how a picture goes in, and how its outputs become boxes.
struct DetectorDescription {
  InputEncoding encoding{};
  image::Fit fit{};
  HeadKind head = HeadKind::darknet;
  std::vector<std::size_t> strides{};  ///< pixels between cells, of each head in the order of the outputs

  bool operator==(const DetectorDescription&) const = default;
};

/// The description of a detector that is known by name: yolox, as Megvii's YOLOX takes its pictures since
/// version 0.1.1, or nanodet, as NanoDet-m.
/// Sources: Ge et al., "YOLOX" (2021) and its program; the configuration of NanoDet-m.
/// \throws DomainError for any other name
[[nodiscard]] inline DetectorDescription known_description(std::string_view name) {
  if (name == "yolox")
    return {{ColourOrder::bgr, 1}, image::fit_by_name("letterbox_top_left"), HeadKind::yolox, {8, 16, 32}};
  if (name == "nanodet")
    return {{ColourOrder::bgr, 1, {103.53, 116.28, 123.675}, {57.375, 57.12, 58.395}},
            image::fit_by_name("stretch"),
            HeadKind::nanodet,
            {8, 16, 32}};
  throw DomainError("no known detector is called " + in_quotes(name) + "; expected yolox or nanodet");
}

/// The heads that a description means, for an input of the given extents: of each stride s one with
/// ⌈height / s⌉ × ⌈width / s⌉ cells.
///
/// \param classes  K
/// \throws DomainError for heads with anchors, which a description does not have, and for a stride of 0
[[nodiscard]] inline std::vector<Head> heads_of(const DetectorDescription& description, std::size_t classes,
                                                std::size_t input_height, std::size_t input_width) {
  Head head;
  head.classes = classes;
  head.decode = decode_family_of(description.head);
  if (has_anchors(head.decode))
    throw DomainError("heads_of: a description of " + std::string(name_of(description.head)) +
                      " heads, whose anchors it lacks; expected yolox, nanodet or yolov8");
  if (description.head == HeadKind::nanodet) head.order = ChannelOrder::classes_first;
  if (description.head == HeadKind::yolov8) head.bins = 16;
  std::vector<Head> heads;
  for (const std::size_t stride : description.strides) {
    if (stride == 0) throw DomainError("heads_of: a stride is 0, expected at least 1 pixel");
    head.stride = stride;
    head.grid_height = (input_height + stride - 1) / stride;
    head.grid_width = (input_width + stride - 1) / stride;
    heads.push_back(head);
  }
  return heads;
}

/// K of a head with so many channels.
/// \throws ShapeError if the channels leave no class; DomainError as heads_of()
[[nodiscard]] inline std::size_t class_count_of(const DetectorDescription& description,
                                                std::size_t channels) {
  DetectorDescription one = description;
  one.strides = {1};
  const std::size_t others = heads_of(one, 0, 1, 1).front().channel_count();
  if (channels <= others)
    throw ShapeError("class_count_of: outputs of " + std::to_string(channels) +
                     " channels, expected more than " + std::to_string(others) + " for " +
                     std::string(name_of(description.head)) + " heads");
  return channels - others;
}

}  // namespace tapestry::detect

#pragma once
#include <algorithm>
#include <array>
#include <cstddef>
#include <string>
#include <string_view>
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/detect/decoded_outputs.hpp>
#include <tapestry/detect/detector_description.hpp>
#include <tapestry/detect/head.hpp>
#include <tapestry/detect/input_encoding.hpp>
#include <tapestry/image/letterbox.hpp>
#include <vector>

namespace tapestry::detect {

HeadKind head_kind_by_name(std::string_view name) {
  for (const HeadKind kind : head_kinds)
    if (name_of(kind) == name) return kind;
  throw DomainError("no kind of head is called " + in_quotes(name) + "; expected " +
                    std::string(head_kind_names));
}

DetectorDescription known_description(std::string_view name) {
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

std::vector<Head> heads_of(const DetectorDescription& description, std::size_t classes,
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

std::size_t class_count_of(const DetectorDescription& description, std::size_t channels) {
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

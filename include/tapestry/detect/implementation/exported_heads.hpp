#pragma once
#include <tapestry/detect/exported_heads.hpp>
#include <tapestry/detect/implementation/exported_structure.hpp>

namespace tapestry::detect {
namespace detail {
struct OutputGroup {
  std::size_t height = 0, width = 0;
  std::vector<std::size_t> outputs{};
  std::size_t channels = 0;  ///< channels of all outputs together
};

/// Outputs by grid, finest first.
[[nodiscard]] inline std::vector<OutputGroup> grouped_by_grid(const std::string& path,
                                                              const std::vector<nn::Shape>& shapes,
                                                              const std::vector<std::string>& labels) {
  std::vector<OutputGroup> groups;
  for (std::size_t i = 0; i < shapes.size(); ++i) {
    const nn::Shape& shape = shapes[i];
    if (shape.size() != 4 || shape[0] != 1)
      throw file_mismatch({path, "", "not a detector: " + labels.at(i) + " behind its outputs",
                           "[1, C, H, W]", tapestry::detail::to_text(shape)});
    auto group = std::ranges::find_if(groups, [&](const OutputGroup& other) {
      return other.height == shape[2] && other.width == shape[3];
    });
    if (group == groups.end()) group = groups.insert(groups.end(), {shape[2], shape[3], {}, 0});
    group->outputs.push_back(i);
    group->channels += shape[1];
  }
  std::ranges::stable_sort(groups, std::greater<>(), &OutputGroup::height);
  return groups;
}

/// Sorts a group's outputs as its head orders its channels: for yolox boxes (4), objectness (1), classes; for
/// distance boxes and classes in the head's own order.
inline void put_in_order(const Head& head, const std::vector<nn::Shape>& shapes, OutputGroup& group) {
  const std::size_t boxes = head.box_channel_count();
  const auto rank = [&](std::size_t output) {
    const std::size_t channels = shapes[output][1];
    if (channels == boxes) return head.box_channel() == 0 ? 0 : 2;
    return channels == 1 && head.has_objectness() ? 1 : head.box_channel() == 0 ? 2 : 0;
  };
  std::ranges::stable_sort(group.outputs, {}, rank);
}

/// How messages call the nodes of a grid.
[[nodiscard]] inline std::string labels_of(const OutputGroup& group, const std::vector<std::string>& labels) {
  return listed(group.outputs, [&](std::size_t output) { return labels.at(output); });
}

/// The one head of decoded outputs.
/// \param shape  of the value that add_decoded_outputs() made
[[nodiscard]] inline ExportedHeads decoded_heads(const std::string& path, const DetectorDescription& kind,
                                                 const nn::Shape& shape) {
  constexpr std::size_t box = 4;
  if (shape.at(1) <= box)
    throw other_kind(path, kind, "classes of output " + in_quotes(kind.decoded.scores), "at least 1", "0");
  Head head;
  head.classes = shape[1] - box;
  head.decode = DecodeFamily::decoded;
  head.grid_height = 1;
  head.grid_width = shape.at(3);
  return {{head}, {{0, 0, 0, nn::size_of(shape)}}};
}

/// The heads of a description, with as many classes as the outputs of the first grid have room for.
[[nodiscard]] inline std::vector<Head> described_heads(
    const std::string& path, const DetectorDescription& kind, const OutputGroup& group,
    const std::vector<std::string>& labels, std::size_t input_height, std::size_t input_width) try {
  const Head first = heads_of(kind, 0, input_height, input_width).front();
  const std::size_t anchors = first.anchor_count();
  if (group.channels <= first.channel_count() || group.channels % anchors != 0)
    throw other_kind(path, kind, "channels of " + labels_of(group, labels),
                     "more than " + std::to_string(first.channel_count()) +
                         (anchors > 1 ? " and a multiple of " + std::to_string(anchors) : ""),
                     std::to_string(group.channels));
  return heads_of(kind, class_count_of(kind, group.channels), input_height, input_width);
} catch (const DomainError& error) {
  throw file_mismatch({path, "", error.what()});
}
}  // namespace detail

ExportedHeads exported_heads(const std::string& path, const DetectorDescription& kind,
                             const std::vector<nn::Shape>& shapes, const std::vector<std::string>& labels,
                             std::size_t input_height, std::size_t input_width) {
  const auto refuse = [&](const std::string& what, const std::string& expected, const std::string& found) {
    throw detail::other_kind(path, kind, what, expected, found);
  };
  if (decode_family_of(kind.head) == DecodeFamily::decoded)
    return detail::decoded_heads(path, kind, shapes.front());
  auto groups = detail::grouped_by_grid(path, shapes, labels);
  if (groups.size() != kind.strides.size() || groups.empty())
    refuse("grids of outputs", std::to_string(kind.strides.size()), std::to_string(groups.size()));
  ExportedHeads exported{
      detail::described_heads(path, kind, groups.front(), labels, input_height, input_width), {}};
  for (std::size_t h = 0; h < groups.size(); ++h) {
    detail::OutputGroup& group = groups[h];
    const Head& head = exported.heads[h];
    if (group.height != head.grid_height || group.width != head.grid_width)
      refuse("grid of stride " + std::to_string(head.stride),
             std::to_string(head.grid_height) + " x " + std::to_string(head.grid_width),
             std::to_string(group.height) + " x " + std::to_string(group.width));
    if (group.channels != head.channel_count())
      refuse("channels at stride " + std::to_string(head.stride), std::to_string(head.channel_count()),
             std::to_string(group.channels));
    if (has_anchors(head.decode) && group.outputs.size() > 1)
      refuse("outputs of stride " + std::to_string(head.stride) + ", whose anchors stand side by side", "1",
             std::to_string(group.outputs.size()));
    detail::put_in_order(head, shapes, group);
    std::size_t channel = 0;
    for (const std::size_t output : group.outputs) {
      exported.pieces.push_back({output, h, channel, nn::size_of(shapes[output])});
      channel += shapes[output][1];
    }
  }
  return exported;
}
}  // namespace tapestry::detect

#pragma once
#include <tapestry/nn/detail/network/operator_context.hpp>
#include <tapestry/nn/detail/network/simplify/editable_graph.hpp>

namespace tapestry::nn {
namespace detail {
[[nodiscard]] inline bool has_axis(const Node& node, std::int64_t axis, std::size_t rank) {
  const std::int64_t own = attribute_of<std::int64_t>(node, "axis", 0);
  return own == axis || own + static_cast<std::int64_t>(rank) == axis;
}

/// Merges Concat of two tensors, ChannelShuffle in two groups and possibly Split to InterleaveChannels; i is
/// the ChannelShuffle.
inline void merge_interleaving(EditableGraph& graph, std::size_t i) {
  if (!graph.is(i, "ChannelShuffle") || attribute_of<std::int64_t>(graph.node(i), "group", 1) != 2) return;
  const Node shuffle = graph.node(i);
  const std::size_t join = graph.maker(shuffle.inputs[0]);
  if (!graph.is(join, "Concat") || graph.only_reader(shuffle.inputs[0]) != i) return;
  const Node both = graph.node(join);
  if (both.inputs.size() != 2 || !has_axis(both, 1, 4) ||
      !graph.have_same_shape(both.inputs[0], both.inputs[1]))
    return;
  Node merged{shuffle.name, "InterleaveChannels", both.inputs, shuffle.outputs, {}};
  const std::size_t cut = graph.only_reader(shuffle.outputs[0]);
  std::size_t place = i;
  if (graph.is(cut, "Split") && has_axis(graph.node(cut), 1, 4)) {
    std::vector<std::int64_t> channels;
    for (const std::string& output : graph.node(cut).outputs)
      if (const Shape* shape = graph.shape(output); shape != nullptr && shape->size() == 4)
        channels.push_back(static_cast<std::int64_t>((*shape)[1]));
    if (channels.size() == graph.node(cut).outputs.size()) {
      merged.outputs = graph.node(cut).outputs;
      merged.attributes["split"] = channels;
      place = cut;
      graph.remove(i);
    }
  }
  graph.remove(join);
  graph.replace(place, std::move(merged));
}

/// Pixels of a picture that a value holds: every step-th row and column from the first on.
struct GridOfPixels {
  std::string picture{};
  std::array<std::size_t, 2> first{0, 0}, step{1, 1};  ///< rows, columns
};

/// Applies node i to a grid; returns false unless it is a Slice of rows or columns to their end.
[[nodiscard]] inline bool follow_slice(const EditableGraph& graph, std::size_t i, GridOfPixels& grid) {
  const Node& node = graph.node(i);
  if (node.operation != "Slice" || node.inputs.size() != 5 || graph.opset() < 10) return false;
  const Constant* given[5] = {};
  for (std::size_t k = 1; k < 5; ++k)
    if (given[k] = graph.constant(node.inputs[k]); given[k] == nullptr) return false;
  const Shape *in = graph.shape(node.inputs[0]), *out = graph.shape(node.outputs[0]);
  if (in == nullptr || out == nullptr || in->size() != 4) return false;
  for (std::size_t k = 0; k < given[3]->size(); ++k) {
    const auto integer = [&](std::size_t operand) {
      return OperatorContext::to_integer(given[operand]->at(k));
    };
    const std::int64_t first = integer(1), axis = integer(3), step = integer(4);
    const auto place = static_cast<std::size_t>(axis < 0 ? axis + 4 : axis);
    if (place < 2 || place > 3 || step < 1 || first < 0 || static_cast<std::size_t>(first) >= (*in)[place])
      return false;
    const std::size_t own = place - 2, start = static_cast<std::size_t>(first);
    const auto stride = static_cast<std::size_t>(step);
    if (grid.step[own] != 1 || (*out)[place] != ((*in)[place] - start + stride - 1) / stride) return false;
    grid.first[own] = start;
    grid.step[own] = stride;
  }
  grid.picture = node.inputs[0];
  return true;
}

/// Merges a Concat of channels that are grids of pixels of one picture to PixelUnshuffle; i is the Concat.
inline void merge_focus(EditableGraph& graph, std::size_t i) {
  if (!graph.is(i, "Concat")) return;
  const Node join = graph.node(i);
  const Shape* out = graph.shape(join.outputs[0]);
  if (out == nullptr || out->size() != 4 || !has_axis(join, 1, 4)) return;
  std::vector<std::int64_t> places;
  std::optional<GridOfPixels> common;
  for (const std::string& input : join.inputs) {
    GridOfPixels grid{input};
    for (int k = 0; k < 2; ++k) {
      const std::size_t maker = graph.maker(grid.picture);
      if (maker == EditableGraph::none || !follow_slice(graph, maker, grid)) break;
    }
    if (!common) common = grid;
    if (grid.picture != common->picture || grid.step != common->step) return;
    for (const std::size_t first : grid.first) places.push_back(static_cast<std::int64_t>(first));
  }
  if (!common || common->step == std::array<std::size_t, 2>{1, 1}) return;
  const Shape* in = graph.shape(common->picture);
  if (in == nullptr || in->size() != 4) return;
  for (std::size_t axis = 0; axis < 2; ++axis)
    if ((*in)[2 + axis] != (*out)[2 + axis] * common->step[axis]) return;
  for (std::size_t k = 0; k < places.size(); ++k)
    if (places[k] >= static_cast<std::int64_t>(common->step[k % 2])) return;
  const std::vector<std::int64_t> block(common->step.begin(), common->step.end());
  graph.replace(
      i,
      {join.name, "PixelUnshuffle", {common->picture}, join.outputs, {{"block", block}, {"places", places}}});
}

/// The picture that a Reshape turns into the value [N, C, pixels], if the value has no other reader.
[[nodiscard]] inline std::optional<std::string> flattened_picture(const EditableGraph& graph,
                                                                  const std::string& value) {
  const std::size_t maker = graph.maker(value);
  if (!graph.is(maker, "Reshape") || graph.only_reader(value) == EditableGraph::none) return {};
  const std::string& picture = graph.node(maker).inputs[0];
  const Shape *in = graph.shape(picture), *out = graph.shape(value);
  if (in == nullptr || out == nullptr || in->size() != 4 || graph.constant(picture) != nullptr) return {};
  const Shape expected{(*in)[0], (*in)[1], (*in)[2] * (*in)[3]};
  return *out == expected ? std::optional(picture) : std::nullopt;
}

/// Merges a Transpose of [N, C, pixels] to [N, pixels, C] to FlattenPixels, for pictures that are stored in
/// this order anyway; also through a Concat of pixels. i is the Transpose.
inline void merge_flattening(EditableGraph& graph, std::size_t i) {
  if (!graph.is(i, "Transpose")) return;
  const Node turn = graph.node(i);
  if (attribute_of(turn, "perm", std::vector<std::int64_t>()) != std::vector<std::int64_t>{0, 2, 1}) return;
  if (const auto picture = flattened_picture(graph, turn.inputs[0])) {
    graph.remove(graph.maker(turn.inputs[0]));
    graph.replace(i, {turn.name, "FlattenPixels", {*picture}, turn.outputs, {}});
    return;
  }
  const std::size_t join = graph.maker(turn.inputs[0]);
  if (!graph.is(join, "Concat") || graph.only_reader(turn.inputs[0]) != i ||
      !has_axis(graph.node(join), 2, 3))
    return;
  std::vector<std::string> pictures;
  const Node joined = graph.node(join);
  for (const std::string& input : joined.inputs) {
    const auto picture = flattened_picture(graph, input);
    if (!picture) return;
    pictures.push_back(*picture);
  }
  for (std::size_t k = 0; k < pictures.size(); ++k)  // under the names that the Reshapes used
    graph.replace(graph.maker(joined.inputs[k]),
                  {turn.name, "FlattenPixels", {pictures[k]}, {joined.inputs[k]}, {}});
  graph.remove(join);
  graph.replace(i, {joined.name, "Concat", joined.inputs, turn.outputs, {{"axis", std::int64_t(1)}}});
}
}  // namespace detail

/// Replaces operations that renumber elements by operations that suit tensors stored channels last.
inline void merge_views(EditableGraph& graph) {
  for (std::size_t i = 0; i < graph.size(); ++i) {
    detail::merge_interleaving(graph, i);
    detail::merge_focus(graph, i);
    detail::merge_flattening(graph, i);
  }
}
}  // namespace tapestry::nn

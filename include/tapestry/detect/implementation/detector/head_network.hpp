#pragma once
#include <tapestry/detect/exported_heads.hpp>
#include <tapestry/detect/implementation/detector/claim.hpp>
#include <tapestry/nn/network/program_builder.hpp>
#include <tapestry/nn/network/staged_network.hpp>

namespace tapestry::detect::detail {
/// Checks the extents of decoded outputs, each [1, N, channels], or [1, channels, N] where channels are
/// first.
/// \throws FileError (mismatch) naming the output
inline void require_decodable(const std::string& path, const DetectorDescription& kind,
                              const nn::Shape& boxes, const nn::Shape& scores) {
  const DecodedOutputs& outputs = kind.decoded;
  const std::size_t channel_axis = outputs.channels_first ? 1 : 2, candidate_axis = 3 - channel_axis;
  const auto require = [&](const std::string& name, const nn::Shape& shape, const std::string& channels,
                           std::size_t candidates, auto fits) {
    const std::string count = candidates == 0 ? "candidates" : std::to_string(candidates);
    if (shape.size() == 3 && shape[0] == 1 && fits(shape[channel_axis]) &&
        (candidates == 0 || shape[candidate_axis] == candidates))
      return;
    throw other_kind(path, kind, "output " + in_quotes(name),
                     outputs.channels_first ? "[1, " + channels + ", " + count + "]"
                                            : "[1, " + count + ", " + channels + "]",
                     tapestry::detail::to_text(shape));
  };
  if (kind.head == HeadKind::end_to_end)
    return require(outputs.boxes, boxes, "6", 0, [](std::size_t channels) { return channels == 6; });
  const std::size_t background = outputs.background == Background::none ? 0 : 1;
  const auto more_than = [](std::size_t least) {
    return [least](std::size_t channels) { return channels > least; };
  };
  if (outputs.boxes == outputs.scores) {
    const std::size_t others = 4 + (outputs.has_objectness ? 1 : 0) + background;
    require(outputs.boxes, boxes, std::to_string(others) + " + classes", 0, more_than(others));
    return;
  }
  require(outputs.boxes, boxes, "4", 0, [](std::size_t channels) { return channels == 4; });
  require(outputs.scores, scores, background == 0 ? "classes" : "1 + classes", boxes[candidate_axis],
          more_than(background));
}

inline void require_value(const nn::NetworkDescription& network, const std::string& what,
                          const std::string& name) {
  if (nn::maker_of(network, name) == nullptr)
    throw file_mismatch({network.path, "", "no node makes the " + what + " " + in_quotes(name)});
}

/// The network with other outputs: the values that the heads are computed from, then the layers, then the
/// value that a claim is about.
/// \param lacks_axis  whether outputs may lack the axis of the picture
[[nodiscard]] inline nn::NetworkDescription showing_heads(const nn::NetworkDescription& network,
                                                          const DetectorDescription& kind, std::size_t size,
                                                          const std::vector<std::string>& layers,
                                                          bool lacks_axis) {
  for (const std::string& layer : layers) require_value(network, "layer", layer);
  require_layers_of(network, kind);
  if (decode_family_of(kind.head) != DecodeFamily::decoded) {
    auto outputs = raw_outputs(network);
    outputs.insert(outputs.end(), layers.begin(), layers.end());
    return nn::pruned(network, std::move(outputs));
  }
  require_classes(kind);
  for (const std::string& name : {kind.decoded.boxes, kind.decoded.scores, kind.decoded.labels})
    if (!name.empty()) require_value(network, "output", name);
  const auto input = picture_extents(network, size).begin()->second;
  auto shown = network;
  const auto added = add_decoded_outputs(shown, kind.decoded, input[2], input[3], lacks_axis);
  std::vector<std::string> outputs{added.logits};
  outputs.insert(outputs.end(), layers.begin(), layers.end());
  if (has_claim(kind)) outputs.push_back(added.scores);
  return nn::pruned(std::move(shown), std::move(outputs));
}

/// Extents of a value of boxes or scores, with the axis of the picture.
[[nodiscard]] inline nn::Shape shape_of_one_picture(const nn::NetworkFacts& facts, const std::string& name) {
  nn::Shape shape = facts.at(name).shape;
  if (shape.size() == 2) shape.insert(shape.begin(), 1);
  return shape;
}

/// The network itself, or, where its picture is [3, H, W], one that takes [1, 3, H, W].
[[nodiscard]] inline std::shared_ptr<const nn::NetworkDescription> of_batch(
    const nn::NetworkDescription& network) {
  constexpr std::size_t axes = 3;
  if (network.inputs.size() != 1 || network.inputs.front().shape.size() != axes)
    return {std::shared_ptr<const void>(), &network};
  auto batched = std::make_shared<nn::NetworkDescription>(network);
  nn::InputDescription& input = batched->inputs.front();
  const std::string picture = input.name, index = picture + ", the first";
  input.name += ", one behind the other";
  input.shape.insert(input.shape.begin(), 1);
  batched->constants[index] = {{}, nn::ElementType::integer, std::vector<double>{0}};
  batched->nodes.insert(batched->nodes.begin(),
                        {index, "Gather", {input.name, index}, {picture}, {{"axis", std::int64_t(0)}}});
  return batched;
}

/// Whether the extents of a network's results may depend on values.
[[nodiscard]] inline bool may_depend_on_values(const nn::NetworkDescription& network) {
  constexpr std::array<std::string_view, 5> choosing{"If", "Loop", "NonMaxSuppression", "NonZero", "TopK"};
  return std::ranges::any_of(network.nodes, [&](const nn::Node& node) {
    return std::ranges::find(choosing, node.operation) != choosing.end();
  });
}

/// Stands for a network that runs in stages wherever one of fixed extents is required.
template <std::floating_point T>
[[nodiscard]] nn::Network<T> stand_in(const std::string& path, const nn::Shape& input) {
  nn::NetworkDescription same;
  same.path = path;
  same.opset = 13;
  same.inputs = {{"picture", {input.begin(), input.end()}}};
  same.outputs = {"same"};
  same.nodes = {{"same", "Identity", {"picture"}, {"same"}, {}}};
  return nn::Network<T>(std::move(same), {}, true);
}

/// The network that shows a detector's heads.
///
/// \param network  as the file has it
/// \param stages   receives the network if its extents depend on the picture; then another one is returned,
///                 which only has its input
/// \param show     makes the same with the heads' outputs; gets whether these may lack the picture's axis
/// \throws FileError (mismatch) as nn::Network, or as require_decodable() where the nodes that decode the
///         outputs do not fit these
template <std::floating_point T, class Show>
[[nodiscard]] nn::Network<T> network_of_heads(const nn::NetworkDescription& network,
                                              const DetectorDescription& kind,
                                              const std::map<std::string, nn::Shape>& inputs, bool simplifies,
                                              std::unique_ptr<nn::StagedNetwork<T>>& stages, Show show) {
  nn::NetworkDescription shown = show(false);
  try {
    return nn::Network<T>(std::move(shown), inputs, true, simplifies);
  } catch (const FileError&) {
    if (decode_family_of(kind.head) != DecodeFamily::decoded) throw;
    const DecodedOutputs& decoded = kind.decoded;
    const auto outputs = nn::pruned(network, {decoded.boxes, decoded.scores});
    nn::ProgramBuilder<T> builder(outputs, inputs, false, false);
    try {
      static_cast<void>(builder.build());
    } catch (const FileError&) {  // of the file's own nodes
      if (!may_depend_on_values(outputs)) throw;
      stages = std::make_unique<nn::StagedNetwork<T>>(show(true), inputs);
      return stand_in<T>(network.path, inputs.begin()->second);
    }
    if (decoded.has_box_for_each_class || !decoded.labels.empty()) throw;
    const auto facts = builder.facts();
    require_decodable(network.path, kind, shape_of_one_picture(facts, decoded.boxes),
                      shape_of_one_picture(facts, decoded.scores));
    return nn::Network<T>(show(true), inputs, true, simplifies);
  }
}
}  // namespace tapestry::detect::detail

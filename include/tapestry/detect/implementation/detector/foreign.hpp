#pragma once
#include <algorithm>
#include <concepts>
#include <cstddef>
#include <map>
#include <mutex>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/detect/decoded_outputs.hpp>
#include <tapestry/detect/detail/input_encoding.hpp>
#include <tapestry/detect/detector.hpp>
#include <tapestry/detect/detector_description.hpp>
#include <tapestry/detect/exported_heads.hpp>
#include <tapestry/detect/implementation/detector/claim.hpp>
#include <tapestry/image/batch.hpp>
#include <tapestry/nn/network/description.hpp>
#include <tapestry/nn/network/network.hpp>
#include <tapestry/nn/network/program_builder.hpp>
#include <tapestry/nn/network/tensor.hpp>
#include <tapestry/nn/workspace.hpp>
#include <utility>
#include <vector>

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
    throw FileError(ErrorKind::mismatch, {path, "",
                                          "not a detector of the kind " + std::string(name_of(kind.head)) +
                                              ": output " + in_quotes(name),
                                          outputs.channels_first ? "[1, " + channels + ", " + count + "]"
                                                                 : "[1, " + count + ", " + channels + "]",
                                          tapestry::detail::to_text(shape)});
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

/// Gives values of one picture that have no axis for it, [N, channels], that axis.
/// \returns the description's outputs by their new names; false if all have it
inline bool add_picture_axis(nn::NetworkDescription& network, const nn::NetworkFacts& facts,
                             DecodedOutputs& outputs) {
  const DecodedOutputs before = outputs;
  for (std::string* name : {&outputs.boxes, &outputs.scores}) {
    const auto found = facts.find(*name);
    if (found == facts.end() || found->second.shape.size() != 2) continue;
    const std::string raised = *name + " of one picture";
    nn::Node node{raised, "Unsqueeze", {*name}, {raised}, {{"axes", std::vector<std::int64_t>{0}}}};
    if (network.opset >= 13) {
      const std::string axes = raised + ", axes";
      network.constants[axes] = {{1}, nn::ElementType::integer, std::vector<double>{0}};
      node.inputs.push_back(axes);
      node.attributes.clear();
    }
    if (nn::maker_of(network, raised) == nullptr) network.nodes.push_back(std::move(node));
    *name = raised;
  }
  return !(outputs == before);
}

/// The network that shows a detector's heads.
///
/// \param network  as the file has it
/// \param show     makes the same with the heads' outputs, for a description of them
/// \throws FileError (mismatch) as nn::Network, or as require_decodable() where the nodes that decode outputs
///         do not fit these
template <std::floating_point T, class Show>
[[nodiscard]] nn::Network<T> network_of_heads(const nn::NetworkDescription& network,
                                              const DetectorDescription& kind,
                                              const std::map<std::string, nn::Shape>& inputs, bool simplifies,
                                              Show show) {
  nn::NetworkDescription shown = show(network, kind);
  try {
    return nn::Network<T>(std::move(shown), inputs, true, simplifies);
  } catch (const FileError&) {
    if (decode_family_of(kind.head) != DecodeFamily::decoded) throw;
    const auto outputs = nn::pruned(network, {kind.decoded.boxes, kind.decoded.scores});
    nn::ProgramBuilder<T> builder(outputs, inputs, false, false);
    static_cast<void>(builder.build());  // throws the errors of the file's own nodes
    const auto facts = builder.facts();
    nn::NetworkDescription raised = network;
    DetectorDescription of_raised = kind;
    if (add_picture_axis(raised, facts, of_raised.decoded))
      return network_of_heads<T>(raised, of_raised, inputs, simplifies, show);
    require_decodable(network.path, kind, facts.at(kind.decoded.boxes).shape,
                      facts.at(kind.decoded.scores).shape);
    throw;
  }
}

}  // namespace tapestry::detect::detail

namespace tapestry::detect {

namespace detail {
inline constexpr const char* foreign_subject = "outputs of a foreign engine";

[[nodiscard]] inline std::vector<ForeignOutput> first_outputs(const ForeignEngine& engine, std::size_t size) {
  if (!engine) throw DomainError("Detector: the engine is an empty function");
  return engine(std::vector<float>(size));
}

[[nodiscard]] inline std::vector<nn::Shape> shapes_of(const std::vector<ForeignOutput>& outputs) {
  std::vector<nn::Shape> shapes;
  for (const ForeignOutput& output : outputs) {
    if (nn::size_of(output.shape) != output.values.size())
      throw FileError(ErrorKind::mismatch,
                      {foreign_subject, "", "values of an output", std::to_string(nn::size_of(output.shape)),
                       std::to_string(output.values.size())});
    shapes.push_back(output.shape);
  }
  return shapes;
}

/// The network that makes a head's logits of a foreign engine's outputs of these extents.
[[nodiscard]] inline nn::NetworkDescription decoding_of(const DetectorDescription& kind,
                                                        const std::vector<nn::Shape>& shapes,
                                                        std::size_t height, std::size_t width) {
  if (decode_family_of(kind.head) != DecodeFamily::decoded)
    throw DomainError({"Detector: heads of a foreign engine are ", name_of(kind.head),
                       ", expected boxes_and_scores or end_to_end"});
  require_classes(kind);
  const std::vector<std::string> names{kind.decoded.boxes, kind.decoded.scores};
  const std::size_t count = names[0] == names[1] ? 1 : 2;
  if (shapes.size() != count)
    throw FileError(ErrorKind::mismatch, {foreign_subject, "", "outputs of one picture",
                                          std::to_string(count), std::to_string(shapes.size())});
  require_decodable(foreign_subject, kind, shapes.front(), shapes.back());
  nn::NetworkDescription description;
  description.path = foreign_subject;
  description.opset = 13;
  for (std::size_t i = 0; i < count; ++i)
    description.inputs.push_back({names[i], {shapes[i].begin(), shapes[i].end()}});
  description.outputs = {add_decoded_outputs(description, kind.decoded, height, width)};
  return description;
}
}  // namespace detail

template <std::floating_point T>
struct Detector<T>::Foreign {
  ForeignEngine engine;
  std::vector<nn::Shape> shapes;  ///< of its outputs
  std::mutex one_at_a_time{};
};

template <std::floating_point T>
Detector<T>::Detector(const ForeignEngine& engine, DetectorDescription kind, std::size_t height,
                      std::size_t width)
    : kind_(std::move(kind)),
      foreign_(new Foreign{engine, detail::shapes_of(detail::first_outputs(engine, 3 * height * width))}),
      network_(detail::decoding_of(kind_, foreign_->shapes, height, width)),
      height_(height),
      width_(width),
      heads_(exported_heads(detail::foreign_subject, kind_, output_shapes(), {}, height, width)) {
  claim_ = detail::claim_of(detail::foreign_subject, kind_);
}

template <std::floating_point T>
void Detector<T>::run_foreign(const Array<T, 4>& images, Pass<T>& pass) const {
  const Array<T, 4> input = image::planes_of(encoded(images, kind_.encoding));
  std::vector<float> picture(image_size());
  const HeadPiece& piece = heads_.pieces.front();
  const bool judges = claim_ && !claim_->is_judged;
  for (std::size_t n = 0; n < pass.images; ++n) {
    std::transform(input.data() + n * picture.size(), input.data() + (n + 1) * picture.size(),
                   picture.begin(), [](T value) { return static_cast<float>(value); });
    const auto outputs = [&] {
      const std::lock_guard lock(foreign_->one_at_a_time);
      return foreign_->engine(picture);
    }();
    if (detail::shapes_of(outputs) != foreign_->shapes)
      throw FileError(ErrorKind::mismatch,
                      {detail::foreign_subject, "", "extents that change from picture to picture"});
    std::vector<nn::Buffer<T>> values(outputs.size());
    std::vector<const T*> pointers;
    for (std::size_t i = 0; i < outputs.size(); ++i) {
      values[i].resize(outputs[i].values.size());
      std::ranges::transform(outputs[i].values, values[i].data(),
                             [](float value) { return static_cast<T>(value); });
      pointers.push_back(values[i].data());
    }
    if (judges)
      detail::require_as_described(*claim_, kind_.decoded, foreign_->shapes.back(), pointers.back());
    network_.forward(pointers, pass.graph[0]);
    std::copy_n(pass.graph[0].output(0), piece.size, at(piece, pass.logits[0], n));
  }
  if (judges) claim_->is_judged = true;
}

}  // namespace tapestry::detect

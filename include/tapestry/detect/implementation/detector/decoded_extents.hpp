#pragma once
#include <concepts>
#include <cstddef>
#include <map>
#include <string>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/detect/decoded_outputs.hpp>
#include <tapestry/detect/detector_description.hpp>
#include <tapestry/nn/network/network.hpp>
#include <tapestry/nn/network/program_builder.hpp>
#include <tapestry/nn/network/pruned.hpp>
#include <tapestry/nn/network/tensor.hpp>
#include <utility>

namespace tapestry::detect::detail {

/// Checks the extents of decoded outputs, each [1, N, channels], or [1, channels, N] where channels are
/// first. \throws FileError (mismatch) naming the output
inline void require_decodable(const std::string& path, const DecodedOutputs& outputs, const nn::Shape& boxes,
                              const nn::Shape& scores) {
  const std::size_t channel_axis = outputs.channels_first ? 1 : 2, candidate_axis = 3 - channel_axis;
  const auto require = [&](const std::string& name, const nn::Shape& shape, const std::string& channels,
                           std::size_t candidates, auto fits) {
    const std::string count = candidates == 0 ? "candidates" : std::to_string(candidates);
    if (shape.size() == 3 && shape[0] == 1 && fits(shape[channel_axis]) &&
        (candidates == 0 || shape[candidate_axis] == candidates))
      return;
    throw FileError(ErrorKind::mismatch,
                    {path, "", "not a detector of the kind boxes_and_scores: output " + in_quotes(name),
                     outputs.channels_first ? "[1, " + channels + ", " + count + "]"
                                            : "[1, " + count + ", " + channels + "]",
                     tapestry::detail::to_text(shape)});
  };
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

/// The network that shows a detector's heads.
///
/// \param network  as the file has it
/// \param shown    the same with the heads' outputs
/// \throws FileError (mismatch) as nn::Network, or as require_decodable() where the nodes that decode outputs
///         do not fit these
template <std::floating_point T>
[[nodiscard]] nn::Network<T> network_of_heads(const nn::NetworkDescription& network,
                                              nn::NetworkDescription shown, const DetectorDescription& kind,
                                              const std::map<std::string, nn::Shape>& inputs,
                                              bool simplifies) {
  try {
    return nn::Network<T>(std::move(shown), inputs, true, simplifies);
  } catch (const FileError&) {
    if (kind.head != HeadKind::boxes_and_scores) throw;
    const auto outputs = nn::pruned(network, {kind.decoded.boxes, kind.decoded.scores});
    nn::ProgramBuilder<T> builder(outputs, inputs, false, false);
    static_cast<void>(builder.build());  // throws what is wrong with the file's own nodes
    const auto facts = builder.facts();
    require_decodable(network.path, kind.decoded, facts.at(kind.decoded.boxes).shape,
                      facts.at(kind.decoded.scores).shape);
    throw;
  }
}

}  // namespace tapestry::detect::detail

#pragma once
#include <tapestry/detect/detector_description.hpp>

namespace tapestry::detect::detail {
[[nodiscard]] inline FileError other_kind(const std::string& path, const DetectorDescription& kind,
                                          const std::string& what, const std::string& expected,
                                          const std::string& found) {
  return file_mismatch({path, "",
                        "not a detector of the kind " + std::string(name_of(kind.head)) + ": " + what,
                        expected, found});
}

/// \throws DomainError unless an end-to-end output, and no other one, has a number of classes
inline void require_classes(const DetectorDescription& kind) {
  if ((kind.head == HeadKind::end_to_end) == (kind.decoded.classes > 0)) return;
  throw DomainError({"Detector: decoded.classes of heads ", name_of(kind.head), " is ", kind.decoded.classes,
                     ", expected ", (kind.decoded.classes > 0 ? "0" : "at least 1")});
}

/// Whether a description states the values of the output with scores.
[[nodiscard]] inline bool has_claim(const DetectorDescription& kind) {
  if (decode_family_of(kind.head) != DecodeFamily::decoded) return false;
  return kind.decoded.classes > 0 || kind.decoded.score_form == ScoreForm::probabilities;
}

[[nodiscard]] inline std::unique_ptr<OutputClaim> claim_of(const std::string& path,
                                                           const DetectorDescription& kind) {
  if (!has_claim(kind)) return nullptr;
  auto claim = std::make_unique<OutputClaim>();
  claim->path = path;
  return claim;
}

/// Checks the values of the output with scores against the description: probabilities lie from 0 to 1,
/// numbers of classes, where the score is above 0, are whole and below K. NaN passes.
///
/// \param shape   [1, N, channels], or [1, channels, N] where channels are first; N may be 0
/// \param values  in row-major order
/// \throws FileError (mismatch) naming the output, the expected values and the first other value
template <std::floating_point T>
void require_as_described(const OutputClaim& claim, const DecodedOutputs& outputs, const nn::Shape& shape,
                          const T* values) {
  const std::size_t channel_axis = outputs.channels_first ? 1 : 2;
  const std::size_t channels = shape[channel_axis], candidates = shape[3 - channel_axis];
  const auto value = [&](std::size_t candidate, std::size_t channel) {
    return static_cast<double>(
        values[outputs.channels_first ? channel * candidates + candidate : candidate * channels + channel]);
  };
  const auto refuse = [&](const char* what, std::size_t candidate, std::size_t channel,
                          const std::string& expected) {
    throw file_mismatch({claim.path, "",
                         "output " + in_quotes(outputs.scores) + " is not as described: " + what +
                             " of candidate " + std::to_string(candidate) + " in channel " +
                             std::to_string(channel),
                         expected, std::to_string(value(candidate, channel))});
  };
  constexpr std::size_t box = 4;
  const bool is_chosen = outputs.classes > 0;
  const std::size_t first = is_chosen || outputs.boxes == outputs.scores ? box : 0,
                    end = is_chosen ? box + 1 : channels;
  for (std::size_t n = 0; n < candidates; ++n) {
    for (std::size_t c = first; c < end && outputs.score_form == ScoreForm::probabilities; ++c)
      if (value(n, c) < -claim_tolerance || value(n, c) > 1 + claim_tolerance)
        refuse("the probability", n, c, "0 to 1");
    if (!is_chosen || !(value(n, box) > 0)) continue;
    const double number = value(n, box + 1);
    if (number != std::floor(number) || number < 0 || number >= static_cast<double>(outputs.classes))
      refuse("the number of the class", n, box + 1,
             "a whole number from 0 to " + std::to_string(outputs.classes - 1));
  }
}
}  // namespace tapestry::detect::detail

#pragma once
#include <cstdint>
#include <map>
#include <string>
#include <tapestry/core/compiled.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/detect/decode_family.hpp>

namespace tapestry::io {

/// What a converted detector says about itself, beside its tensors.
struct DetectorMetadata {
  std::string cfg;                   ///< text of the Darknet cfg file, whole and unchanged
  std::uint64_t images_seen = 0;     ///< in training
  bool is_folded = false;            ///< batch normalisation is part of the weights
  double batch_norm_epsilon = 1e-5;  ///< inside the root; of a folded detector the one folded in
  detect::DecodeFamily decode = detect::DecodeFamily::darknet;  ///< nothing else in a file tells it
};

/// The metadata as fields of a safetensors file. Numbers are the shortest decimals that read back the same.
[[nodiscard]] std::map<std::string, std::string> fields_of(const DetectorMetadata& metadata);

/// The reverse of fields_of(); further fields are left to others.
/// \throws FileError  mismatch for a field that is missing or means what is not supported, malformed for one
///                    that makes no sense or a cfg that does not have its hash
[[nodiscard]] DetectorMetadata parse_detector_metadata(const std::map<std::string, std::string>& fields,
                                                       const std::string& path);

}  // namespace tapestry::io

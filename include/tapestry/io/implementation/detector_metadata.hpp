#pragma once
#include <cctype>
#include <tapestry/image/colour_space.hpp>
#include <tapestry/io/detector_file.hpp>
#include <tapestry/io/read_detector.hpp>
#include <tapestry/io/text_lines.hpp>

namespace tapestry::io {

namespace detail {
inline constexpr const char* detector_format = "tapestry-detector";
}  // namespace detail

std::map<std::string, std::string> fields_of(const DetectorMetadata& metadata) {
  std::array<char, 32> epsilon{};
  char* const end =
      std::to_chars(epsilon.data(), epsilon.data() + epsilon.size(), metadata.batch_norm_epsilon).ptr;
  return {{"format", detail::detector_format},
          {"decode", std::string(detect::name_of(metadata.decode))},
          {"cfg", metadata.cfg},
          {"cfg_sha256", sha256(metadata.cfg)},
          {"images_seen", std::to_string(metadata.images_seen)},
          {"batch_norm", metadata.is_folded ? "folded" : "kept"},
          {"batch_norm_epsilon", std::string(epsilon.data(), end)}};
}

DetectorMetadata parse_detector_metadata(const std::map<std::string, std::string>& fields,
                                         const std::string& path) {
  const auto fail = [&](ErrorKind kind, const std::string& name, const std::string& what,
                        const std::string& expected, const std::string& found = "") {
    throw FileError(kind, {path, "", "metadata field " + in_quotes(name) + " " + what, expected, found});
  };
  const auto field = [&](const std::string& name, const std::string& expected) {
    const auto found = fields.find(name);
    if (found == fields.end()) fail(ErrorKind::mismatch, name, "is missing", expected);
    return found->second;
  };
  const auto require = [&](const std::string& name, const std::string& expected) {
    const std::string found = field(name, expected);
    if (found != expected) fail(ErrorKind::mismatch, name, "is not supported", expected, in_quotes(found));
  };
  require("format", detail::detector_format);
  DetectorMetadata metadata;
  const std::string families(detect::anchored_family_names);
  const std::string decode = field("decode", families);
  try {
    metadata.decode = detect::decode_family_by_name(decode);
    if (!detect::has_anchors(metadata.decode)) throw DomainError("a cfg's heads have anchors");
  } catch (const DomainError&) {
    fail(ErrorKind::mismatch, "decode", "is not supported", families, in_quotes(decode));
  }
  metadata.cfg = field("cfg", "the text of a Darknet cfg file");
  const std::string hash = field("cfg_sha256", "the hash of the cfg");
  if (hash != sha256(metadata.cfg))
    fail(ErrorKind::malformed, "cfg", "does not have its hash, so one of them was edited", in_quotes(hash),
         sha256(metadata.cfg));
  const std::string folding = field("batch_norm", "kept or folded");
  if (folding != "kept" && folding != "folded")
    fail(ErrorKind::malformed, "batch_norm", "makes no sense", "kept or folded", in_quotes(folding));
  metadata.is_folded = folding == "folded";
  const std::string seen = field("images_seen", "a count");
  if (!parse_integer(seen, metadata.images_seen))
    fail(ErrorKind::malformed, "images_seen", "makes no sense", "a count", in_quotes(seen));
  const std::string epsilon = field("batch_norm_epsilon", "a number above 0");
  if (!parse_number(epsilon, metadata.batch_norm_epsilon) || !(metadata.batch_norm_epsilon > 0))
    fail(ErrorKind::malformed, "batch_norm_epsilon", "makes no sense", "a number above 0",
         in_quotes(epsilon));
  return metadata;
}

bool is_of_darknet(const nn::NetworkDescription& network) {
  const auto format = network.metadata.find("format");
  return format != network.metadata.end() && format->second == detail::detector_format;
}

std::string description_beside(const std::string& weights) {
  if (!is_onnx(weights)) return "";
  const auto beside = path_of(weights).replace_extension(".json");
  std::error_code ignored;
  return std::filesystem::is_regular_file(beside, ignored) ? beside.string() : "";
}

}  // namespace tapestry::io

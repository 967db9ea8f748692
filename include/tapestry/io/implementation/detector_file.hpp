#pragma once
#include <tapestry/image/colour_space.hpp>
#include <tapestry/io/detector_file.hpp>
#include <tapestry/io/onnx/onnx_file.hpp>
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

detect::NetworkConfig adapted(detect::NetworkConfig config, const DetectorMetadata& metadata) {
  config = detect::with_decode(std::move(config), metadata.decode);
  config.batch_norm_epsilon = metadata.batch_norm_epsilon;
  return metadata.is_folded ? detect::without_batch_norm(std::move(config)) : config;
}

std::size_t write_detector_file(const std::string& path, const detect::DarknetModel<float>& model,
                                const std::string& cfg) {
  const std::string& name = model.config().name;
  const std::size_t sound = utf8_prefix(cfg);
  if (sound < cfg.size())
    throw malformed_file(
        {name, "@" + std::to_string(sound), "not UTF-8, as text within an ONNX model has to be"});
  const auto normalises = [](const detect::LayerConfig& layer) { return layer.batch_normalize; };
  const auto config = parse_network_config(cfg, name);
  const DetectorMetadata metadata{cfg, model.images_seen(),
                                  std::ranges::any_of(config.layers, normalises) &&
                                      std::ranges::none_of(model.config().layers, normalises),
                                  model.config().batch_norm_epsilon,
                                  detect::decode_family_of(model.config())};
  const std::size_t needed = detail::layout_of(adapted(config, metadata)).count;
  if (model.layout().count != needed)
    throw ShapeError({"write_detector_file: parameters of the model are [", model.layout().count,
                      "], expected [", needed, "]"});
  auto network = model.description();
  network.metadata = fields_of(metadata);
  std::map<std::string, nn::Shape> outputs;
  for (std::size_t h = 0; h < model.heads().size(); ++h) {
    const detect::Head& head = model.heads()[h];
    outputs[network.outputs.at(h)] = {1, head.channel_count(), head.grid_height, head.grid_width};
  }
  write_onnx(path, network, outputs);
  return network.nodes.size();
}
}  // namespace tapestry::io

#pragma once
#include <algorithm>
#include <array>
#include <cctype>
#include <charconv>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <system_error>
#include <tapestry/core/array.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/detect/darknet_model.hpp>
#include <tapestry/detect/detector.hpp>
#include <tapestry/detect/exported_heads.hpp>
#include <tapestry/detect/head.hpp>
#include <tapestry/image/colour_space.hpp>
#include <tapestry/image/letterbox.hpp>
#include <tapestry/io/darknet/model_file.hpp>
#include <tapestry/io/detector_file.hpp>
#include <tapestry/io/file_source.hpp>
#include <tapestry/io/frame_file.hpp>
#include <tapestry/io/onnx/onnx_file.hpp>
#include <tapestry/io/read_detector.hpp>
#include <tapestry/io/safetensors_file.hpp>
#include <tapestry/io/text_lines.hpp>
#include <tapestry/io/text_lists.hpp>
#include <tapestry/nn/engine.hpp>
#include <utility>
#include <vector>

namespace tapestry::io {

std::map<std::string, std::string> fields_of(const DetectorMetadata& metadata) {
  std::array<char, 32> epsilon{};
  char* const end =
      std::to_chars(epsilon.data(), epsilon.data() + epsilon.size(), metadata.batch_norm_epsilon).ptr;
  return {{"format", "tapestry-detector"},
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
  require("format", "tapestry-detector");
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

}  // namespace tapestry::io

namespace tapestry::io::detail {

[[nodiscard]] inline nn::Engine engine_of(const std::string& precision) {
  if (precision == "bfloat16") return nn::Engine::bfloat16;
  if (precision == "float") return nn::Engine::automatic;
  throw DomainError("read_detector: precision is " + in_quotes(precision) + ", expected float or bfloat16");
}

[[nodiscard]] inline FileError no_common_layer(const std::string& path) {
  return FileError(ErrorKind::mismatch,
                   {path, "", "there is no layer that all heads see, to map attention over"});
}

/// The value of a Darknet model's layer with this number or, if empty, of the last layer that all heads
/// depend on.
template <std::floating_point T>
[[nodiscard]] std::string darknet_layer(const detect::DarknetModel<T>& model, const std::string& layer) {
  if (layer.empty()) {
    const auto network = model.description();
    const auto common = detect::common_layer(network, network.outputs);
    return common.empty() ? throw no_common_layer(network.path) : common;
  }
  const bool is_number =
      layer.size() < 6 && std::ranges::all_of(layer, [](unsigned char c) { return std::isdigit(c) != 0; });
  if (!is_number)
    throw Error(ErrorKind::usage, "layer '" + layer + "': layers of Darknet networks are numbers, from 0");
  return model.value_name(std::stoul(layer));
}

template <std::floating_point T>
[[nodiscard]] detect::Detector<T> read_darknet_detector(const DetectorFiles& files,
                                                        std::vector<std::string>* warnings) {
  if (!files.description.empty())
    throw Error(ErrorKind::usage, files.weights + ": is described by its cfg, not by " + files.description);
  std::optional<detect::DecodeFamily> decode;
  if (!files.decode.empty()) decode = detect::decode_family_by_name(files.decode);
  const auto [model, remarks] =
      read_darknet_model<T>(files.config, files.weights, files.size, files.size, decode);
  if (warnings != nullptr) *warnings = remarks;
  if (model.heads().empty())
    throw FileError(ErrorKind::mismatch,
                    {model.config().name, "", "the network has no [yolo] or [region] section"});
  std::vector<std::string> layers;
  for (const std::string& layer : files.layers) layers.push_back(darknet_layer(model, layer));
  return model.detector(layers);
}

/// Description of an ONNX model.
[[nodiscard]] inline detect::DetectorDescription description_for(const DetectorFiles& files,
                                                                 const nn::NetworkDescription& network,
                                                                 std::vector<std::string>* warnings) {
  const std::string file = files.description.empty() ? description_beside(files.weights) : files.description;
  std::optional<detect::DetectorDescription> given, own;
  if (!file.empty()) given = read_detector_description(file, warnings);
  if (const auto found = network.metadata.find(description_key); found != network.metadata.end())
    own = parse_detector_description(found->second, files.weights + ":" + description_key);
  if (own && given && *own != *given)
    throw FileError(ErrorKind::mismatch, {file, "", "contradicts the description within " + files.weights,
                                          "the same one, or no such file", ""});
  if (own) return *own;
  if (given) return *given;
  if (const auto known = detect::recognised_detector(network)) return *known;
  throw Error(
      ErrorKind::usage,
      files.weights +
          ": its outputs are not those of a detector that is known by its layers (YOLOX, NanoDet); a "
          "description must define them, such as a file of {\"head\": \"yolov5\"} beside the model, of its "
          "name with the ending .json");
}

template <std::floating_point T>
[[nodiscard]] detect::Detector<T> read_onnx_detector(const DetectorFiles& files,
                                                     std::vector<std::string>* warnings) {
  for (const std::string& other : {files.config, files.decode})
    if (!other.empty())
      throw Error(
          ErrorKind::usage,
          files.weights + ": an ONNX model takes no cfg and no decode family, but " + other + " was given");
  const auto network = read_onnx(files.weights);
  auto layers = files.layers;
  for (std::string& layer : layers) {
    if (layer.empty()) layer = detect::common_layer(network, detect::raw_outputs(network));
    if (layer.empty()) throw no_common_layer(files.weights);
  }
  return detect::Detector<T>(network, description_for(files, network, warnings), files.size, layers);
}

}  // namespace tapestry::io::detail

namespace tapestry::io {

std::string description_beside(const std::string& weights) {
  if (!is_onnx(weights)) return "";
  const auto beside = std::filesystem::path(weights).replace_extension(".json");
  std::error_code ignored;
  return std::filesystem::is_regular_file(beside, ignored) ? beside.string() : "";
}

template <std::floating_point T>
detect::Detector<T> read_detector(const DetectorFiles& files, std::vector<std::string>* warnings) {
  const nn::Engine engine = detail::engine_of(files.precision);
  auto detector = is_onnx(files.weights) ? detail::read_onnx_detector<T>(files, warnings)
                                         : detail::read_darknet_detector<T>(files, warnings);
  detector.set_engine(engine);
  if (!files.fit.empty()) detector.set_fit(image::fit_by_name(files.fit));
  if (!files.names.empty())
    detector.set_names(read_class_names(files.names, detector.heads().front().classes));
  return detector;
}

template <std::floating_point T>
Array<T, 4> read_input(const detect::Detector<T>& detector, const std::string& path) {
  return detector.input(image::from_bytes<T>(read_picture(path)));
}

template decltype(read_detector<float>) read_detector<float>;
template decltype(read_detector<double>) read_detector<double>;
template decltype(read_input<float>) read_input<float>;
template decltype(read_input<double>) read_input<double>;

}  // namespace tapestry::io

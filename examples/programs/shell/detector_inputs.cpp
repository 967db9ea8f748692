#include "detector_inputs.hpp"

#include <algorithm>
#include <cctype>
#include <optional>
#include <tapestry/detect/graph_detector.hpp>
#include <tapestry/detect/network.hpp>
#include <tapestry/detect/raw_outputs.hpp>
#include <tapestry/detect/recognised_detector.hpp>
#include <tapestry/io/detector_description_file.hpp>
#include <tapestry/io/names_file.hpp>
#include <tapestry/io/network_file.hpp>
#include <tapestry/io/onnx/onnx_file.hpp>
#include <utility>

namespace tapestry::shell {
namespace {

/// The layer of a Darknet network that a number names, or without one the last that all heads see.
std::size_t darknet_layer(const detect::Network<float>& network, const std::string& layer) {
  if (layer.empty()) {
    const auto common = network.common_layer();
    if (common) return *common;
    throw FileError(ErrorKind::mismatch, {network.config().name, "",
                                          "there is no layer that all heads see, to map attention over"});
  }
  const bool is_number = layer.size() < 6 && std::all_of(layer.begin(), layer.end(), [](unsigned char c) {
                           return std::isdigit(c) != 0;
                         });
  if (!is_number)
    throw Error(ErrorKind::usage, "--layer '" + layer + "': layers of Darknet networks are numbers, from 0");
  return std::stoul(layer);
}

nn::Engine engine_of(const DetectorSettings& settings) {
  return settings.precision == "bfloat16" ? nn::Engine::bfloat16 : nn::Engine::automatic;
}

Detector load_darknet(const DetectorSettings& settings, const std::vector<std::string>& layers) {
  if (!settings.detector.empty())
    throw Error(ErrorKind::usage, "--detector describes .onnx weights; those of " + settings.weights +
                                      " are described by a cfg");
  if (settings.cfg.empty() && !io::is_safetensors(settings.weights))
    throw Error(ErrorKind::usage, "--cfg is missing, which " + settings.weights +
                                      " needs; only weights that convert_weights made hold their own");
  std::optional<detect::DecodeFamily> decode;
  if (!settings.decode.empty()) decode = detect::decode_family_by_name(settings.decode);
  auto loaded = io::read_network<float>(settings.cfg, settings.weights, settings.size, settings.size, decode);
  if (loaded.network.heads().empty())
    throw FileError(ErrorKind::mismatch,
                    {loaded.network.config().name, "", "the network has no [yolo] or [region] section"});
  std::vector<std::size_t> told;
  for (const std::string& layer : layers) told.push_back(darknet_layer(loaded.network, layer));
  loaded.network.tell_layers(told);
  loaded.network.set_engine(engine_of(settings));
  const auto fit =
      settings.fit.empty() ? detect::fit_of(loaded.network.config()) : image::fit_by_name(settings.fit);
  Detector detector{std::make_unique<detect::Network<float>>(std::move(loaded.network)),
                    fit,
                    {},
                    std::move(loaded.warnings)};
  return detector;
}

Detector load_onnx(const DetectorSettings& settings, std::vector<std::string> layers) {
  for (const auto& [option, value] :
       {std::pair("--cfg", settings.cfg), std::pair("--decode", settings.decode)})
    if (!value.empty())
      throw Error(ErrorKind::usage, std::string(option) + " is for Darknet weights; " + settings.weights +
                                        " is described by --detector, or recognised");
  const auto network = io::read_onnx(settings.weights);
  const auto kind = settings.detector.empty() ? detect::recognised_detector(network)
                                              : io::read_detector_description(settings.detector);
  if (!kind)
    throw Error(ErrorKind::usage,
                settings.weights +
                    ": its outputs are not those of a detector that is known by its layers (YOLOX, NanoDet); "
                    "--detector says what they are, such as a file of {\"head\": \"yolov5\"}");
  for (std::string& layer : layers) {
    if (layer.empty()) layer = detect::common_layer(network);
    if (layer.empty())
      throw FileError(ErrorKind::mismatch,
                      {settings.weights, "", "there is no layer that all heads see, to map attention over"});
  }
  auto graph = std::make_unique<detect::GraphDetector<float>>(network, *kind, settings.size, layers);
  graph->set_engine(engine_of(settings));
  Detector detector{std::move(graph), kind->fit, {}, {}};
  if (!settings.fit.empty()) detector.fit = image::fit_by_name(settings.fit);
  return detector;
}

}  // namespace

Detector load_detector(const DetectorSettings& settings, const std::vector<std::string>& layers) {
  Detector detector =
      is_onnx(settings.weights) ? load_onnx(settings, layers) : load_darknet(settings, layers);
  if (!settings.names.empty())
    detector.names = io::read_class_names(settings.names, detector.network->heads().front().classes);
  return detector;
}

std::size_t class_index_of(const DetectorSettings& settings, const Detector& detector) {
  if (!detector.names.empty()) return io::class_index(detector.names, settings.class_name);
  const std::string& text = settings.class_name;
  const bool is_number =
      !text.empty() && text.size() < 6 &&
      std::all_of(text.begin(), text.end(), [](unsigned char c) { return std::isdigit(c) != 0; });
  if (!is_number)
    throw Error(ErrorKind::usage, "--class '" + text + "' needs --names; without them it must be a number");
  const std::size_t index = std::stoul(text);
  const std::size_t classes = detector.network->heads().front().classes;
  if (index >= classes)
    throw Error(ErrorKind::mismatch,
                "--class " + text + ": the detector has " + std::to_string(classes) + " classes");
  return index;
}

}  // namespace tapestry::shell

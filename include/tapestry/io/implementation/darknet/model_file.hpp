#pragma once
#include <tapestry/io/darknet/model_file.hpp>
#include <tapestry/io/detail/darknet/known_keys.hpp>
#include <tapestry/io/detail/darknet/layer_parsing.hpp>
#include <tapestry/io/detail/darknet/section.hpp>
#include <tapestry/io/detector_file.hpp>

namespace tapestry::io::detail {

inline void parse_net(SectionReader& reader, detect::NetworkConfig& config) {
  config.line = reader.line();
  config.width = reader.count("width", config.width, 1, 16384);
  config.height = reader.count("height", config.height, 1, 16384);
  config.channels = reader.count("channels", config.channels, 1, 1 << 20);
  if (config.channels != 3) {
    throw reader.error(*reader.find("channels"), "the network is fed with colour pictures", "channels=3",
                       std::to_string(config.channels), ErrorKind::mismatch);
  }
  if (reader.find("letter_box") != nullptr)
    config.letter_box = reader.integer("letter_box", 0, 0, 1, ErrorKind::malformed) != 0;
}

}  // namespace tapestry::io::detail

namespace tapestry::io::detail {

/// The cfg to use with a converted detector: its own, or the given one, which should be equal.
[[nodiscard]] inline detect::NetworkConfig config_for(const DetectorFile& file, const std::string& weights,
                                                      const std::string& cfg,
                                                      std::vector<std::string>& warnings) {
  if (cfg.empty()) return file.config();
  const std::string text = read_text_file(cfg, std::uint64_t(4) << 20U);
  auto config = file.adapted(parse_network_config(text, cfg));
  if (text != file.metadata().cfg)
    warnings.push_back(cfg + ": differs from the cfg inside " + weights +
                       " and is used instead of it; leave it out to use that");
  return config;
}

}  // namespace tapestry::io::detail

namespace tapestry::io {

template <std::floating_point T>
LoadedModel<T> read_darknet_model(const std::string& cfg, const std::string& weights,
                                  std::size_t input_height, std::size_t input_width,
                                  std::optional<detect::DecodeFamily> decode) {
  std::vector<std::string> warnings;
  const auto keep = [&](const std::vector<std::string>& more) {
    warnings.insert(warnings.end(), more.begin(), more.end());
  };
  if (is_safetensors(weights)) {
    const DetectorFile file(weights);
    if (decode && *decode != file.metadata().decode)
      throw Error(ErrorKind::mismatch,
                  {weights, ": is of the decode family ", detect::name_of(file.metadata().decode),
                   ", which contradicts the requested ", detect::name_of(*decode)});
    auto config = detail::config_for(file, weights, cfg, warnings);
    keep(config.warnings);
    keep(detect::decode_warnings(config));
    keep(file.warnings());
    const auto layout = detail::layout_of(config, input_height, input_width);
    auto parameters = file.parameters<T>(config, layout);
    detect::DarknetModel<T> model(std::move(config), std::move(parameters), input_height, input_width);
    model.set_images_seen(file.metadata().images_seen);
    return {std::move(model), std::move(warnings)};
  }
  if (cfg.empty()) throw Error(ErrorKind::usage, {weights, ": Darknet weights need their cfg file"});
  auto config = read_network_config(cfg);
  if (decode) config = detect::with_decode(std::move(config), *decode);
  keep(config.warnings);
  keep(detect::decode_warnings(config));
  const WeightFile file =
      read_weight_file(weights, config, detail::layout_of(config, input_height, input_width));
  keep(file.warnings);
  detect::DarknetModel<T> model(std::move(config), cast<T>(file.parameters), input_height, input_width);
  model.set_images_seen(file.images_seen);
  return {std::move(model), std::move(warnings)};
}

template <std::floating_point T>
LoadedModel<T> read_classifier(const std::string& cfg, const std::string& weights, std::size_t input_height,
                               std::size_t input_width) {
  auto config = read_classifier_config(cfg);
  std::vector<std::string> warnings = config.warnings;
  const WeightFile file =
      read_weight_file(weights, config, detail::layout_of(config, input_height, input_width));
  warnings.insert(warnings.end(), file.warnings.begin(), file.warnings.end());
  detect::DarknetModel<T> model(std::move(config), cast<T>(file.parameters), input_height, input_width);
  model.set_images_seen(file.images_seen);
  return {std::move(model), std::move(warnings)};
}

}  // namespace tapestry::io

#pragma once
#include <tapestry/io/darknet/model_file.hpp>
#include <tapestry/io/detail/npy_header.hpp>
#include <tapestry/io/detector_file.hpp>
#include <tapestry/io/onnx/onnx_file.hpp>

namespace tapestry::io {
namespace detail {
/// The cfg to use with a converted detector: its own, or the given one, which should be equal.
[[nodiscard]] inline detect::NetworkConfig config_for(const DetectorMetadata& metadata,
                                                      const std::string& weights, const std::string& cfg,
                                                      std::vector<std::string>& warnings) {
  const std::string text = cfg.empty() ? metadata.cfg : read_text_file(cfg, largest_cfg_size);
  auto config = adapted(parse_network_config(text, cfg.empty() ? weights + ":cfg" : cfg), metadata);
  if (text != metadata.cfg)
    warnings.push_back(cfg + ": differs from the cfg inside " + weights +
                       " and is used instead of it; leave it out to use that");
  return config;
}

/// The constant of a block of parameters.
/// \throws FileError (mismatch) if it is missing, or of another shape
[[nodiscard]] inline const nn::Constant& constant_of(const nn::NetworkDescription& network,
                                                     const detect::NetworkConfig& config,
                                                     const detect::ParameterBlock& block) {
  const nn::Shape shape = detect::constant_shape(config, block);
  const std::string name = detect::constant_name(block);
  const auto found = network.constants.find(name);
  if (found == network.constants.end() || found->second.shape != shape)
    throw file_mismatch({network.path, "", "constant " + in_quotes(name) + " is not that of " + config.name,
                         shape_text(shape),
                         found == network.constants.end() ? "none" : shape_text(found->second.shape)});
  return found->second;
}

template <std::floating_point T>
[[nodiscard]] LoadedModel<T> with_weights(const detect::NetworkConfig& config, const std::string& weights,
                                          std::size_t input_height, std::size_t input_width) {
  WeightFile file = read_weight_file(weights, config, layout_of(config, input_height, input_width));
  LoadedModel<T> loaded{{config, cast<T>(std::move(file.parameters)), input_height, input_width}};
  loaded.model.set_images_seen(file.images_seen);
  for (const auto& more : {config.warnings, detect::decode_warnings(config), file.warnings})
    loaded.warnings.insert(loaded.warnings.end(), more.begin(), more.end());
  return loaded;
}
}  // namespace detail

template <std::floating_point T>
LoadedModel<T> darknet_model(const nn::NetworkDescription& network, const std::string& cfg,
                             std::size_t input_height, std::size_t input_width,
                             std::optional<detect::DecodeFamily> decode) {
  const auto metadata = parse_detector_metadata(network.metadata, network.path);
  if (decode && *decode != metadata.decode)
    throw Error(ErrorKind::mismatch,
                {network.path, ": is of the decode family ", detect::name_of(metadata.decode),
                 ", which contradicts the requested ", detect::name_of(*decode)});
  std::vector<std::string> warnings;
  const auto config = detail::config_for(metadata, network.path, cfg, warnings);
  for (const auto& more : {config.warnings, detect::decode_warnings(config)})
    warnings.insert(warnings.end(), more.begin(), more.end());
  const auto layout = detail::layout_of(config, input_height, input_width);
  Array<float, 1> parameters(Extents<1>{layout.count});
  for (const detect::ParameterBlock& block : layout.blocks) {
    const nn::Constant& constant = detail::constant_of(network, config, block);
    const std::span<float> values(parameters.data() + block.offset, block.count);
    for (std::size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(constant.at(i));
    detail::check_block(network.path, config, block, values, {});
  }
  detect::DarknetModel<T> model(config, cast<T>(std::move(parameters)), input_height, input_width);
  model.set_images_seen(metadata.images_seen);
  return {std::move(model), std::move(warnings)};
}

template <std::floating_point T>
LoadedModel<T> read_darknet_model(const std::string& cfg, const std::string& weights,
                                  std::size_t input_height, std::size_t input_width,
                                  std::optional<detect::DecodeFamily> decode) {
  if (is_onnx(weights)) return darknet_model<T>(read_onnx(weights), cfg, input_height, input_width, decode);
  if (cfg.empty()) throw Error(ErrorKind::usage, {weights, ": Darknet weights need their cfg file"});
  auto config = read_network_config(cfg);
  if (decode) config = detect::with_decode(std::move(config), *decode);
  return detail::with_weights<T>(config, weights, input_height, input_width);
}

template <std::floating_point T>
LoadedModel<T> read_classifier(const std::string& cfg, const std::string& weights, std::size_t input_height,
                               std::size_t input_width) {
  return detail::with_weights<T>(read_classifier_config(cfg), weights, input_height, input_width);
}
}  // namespace tapestry::io

#pragma once
#include <tapestry/io/darknet/model_file.hpp>
#include <tapestry/io/detector_file.hpp>
#include <tapestry/io/onnx/onnx_file.hpp>
#include <tapestry/io/text_lines.hpp>

namespace tapestry::io {

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
    throw FileError(ErrorKind::malformed,
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

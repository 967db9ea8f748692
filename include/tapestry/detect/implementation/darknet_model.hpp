#pragma once
#include <tapestry/detect/darknet_model.hpp>

namespace tapestry::detect {
template <std::floating_point T>
DarknetModel<T>::DarknetModel(NetworkConfig config, std::optional<Array<T, 1>> parameters,
                              std::size_t input_height, std::size_t input_width)
    : config_(std::move(config)),
      height_(input_height == 0 ? config_.height : input_height),
      width_(input_width == 0 ? config_.width : input_width),
      shapes_(infer_shapes(config_, height_, width_)),
      layout_(parameter_layout(config_, shapes_)),
      parameters_(parameters ? std::move(*parameters) : zeros<T, 1>({layout_.count})) {
  require_shape("DarknetModel", "parameters", parameters_, {layout_.count});
  for (std::size_t i = 0; i < config_.layers.size(); ++i)
    if (is_head(config_.layers[i].kind)) heads_.push_back(detail::head_of(config_.layers[i], shapes_[i]));
}

template <std::floating_point T>
DarknetModel<T>::DarknetModel(NetworkConfig config, std::size_t input_height, std::size_t input_width)
    : DarknetModel(std::move(config), std::optional<Array<T, 1>>(), input_height, input_width) {
  for (const ParameterBlock& block : layout_.blocks)
    if (block.role == ParameterRole::scale || block.role == ParameterRole::variance) fill(block, 1);
}

template <std::floating_point T>
DarknetModel<T>::DarknetModel(NetworkConfig config, Array<T, 1> parameters, std::size_t input_height,
                              std::size_t input_width)
    : DarknetModel(std::move(config), std::optional(std::move(parameters)), input_height, input_width) {}

template <std::floating_point T>
SuppressionMeasure DarknetModel<T>::suppression_measure() const {
  SuppressionMeasure measure;
  for (const LayerConfig& layer : config_.layers)
    if (is_head(layer.kind)) measure.distance_exponent = layer.beta_nms;
  return measure;
}

template <std::floating_point T>
void DarknetModel<T>::initialise(Random& random) {
  for (const ParameterBlock& block : layout_.blocks) {
    fill(block, block.role == ParameterRole::scale || block.role == ParameterRole::variance ? T(1) : T(0));
    if (block.role != ParameterRole::weight) continue;
    const auto fan_in = static_cast<double>(block.count / config_.layers[block.layer].filters);
    const double deviation = std::sqrt(2 / fan_in);
    for (std::size_t i = 0; i < block.count; ++i)
      parameters_[block.offset + i] = static_cast<T>(deviation * random.normal());
  }
}

template <std::floating_point T>
DarknetModel<T> DarknetModel<T>::resized(std::size_t input_height, std::size_t input_width) const {
  DarknetModel other(config_, parameters_, input_height, input_width);
  other.images_seen_ = images_seen_;
  return other;
}

template <std::floating_point T>
std::string DarknetModel<T>::value_name(std::size_t layer) const {
  const auto makers = makers_of_values(config_);
  if (layer >= makers.size() || makers[layer] == picture_value)
    throw file_mismatch({config_.name, "", "layer " + std::to_string(layer) + " cannot be observed",
                         "one that computes something, from 0 to " + std::to_string(makers.size() - 1)});
  return "layer_" + std::to_string(makers[layer]);
}

template <std::floating_point T>
nn::NetworkDescription DarknetModel<T>::description(bool batch_statistics) const {
  return network_description(config_, parameters_, height_, width_, batch_statistics);
}

template <std::floating_point T>
Detector<T> DarknetModel<T>::detector(const std::vector<std::string>& layers) const {
  return make_detector(false, layers, true);
}

template <std::floating_point T>
Detector<T> DarknetModel<T>::learning_detector(bool batch_statistics) const {
  return make_detector(batch_statistics, {}, false);
}

template <std::floating_point T>
Detector<T> DarknetModel<T>::make_detector(bool batch_statistics, const std::vector<std::string>& layers,
                                           bool simplifies) const {
  Detector<T> detector(
      network_description(config_, parameters_, height_, width_, batch_statistics, std::is_same_v<T, float>),
      heads_, layers, simplifies);
  detector.set_fit(fit_of(config_));
  detector.set_suppression_measure(suppression_measure());
  return detector;
}

template <std::floating_point T>
void DarknetModel<T>::take_weights(const Detector<T>& learnt) {
  std::map<std::string_view, std::size_t> offsets;
  for (const nn::WeightBlock& weight : learnt.network().weight_blocks()) offsets[weight.name] = weight.offset;
  const auto weights = learnt.network().weights();
  for (const ParameterBlock& block : layout_.blocks)
    if (const auto found = offsets.find(constant_name(block)); found != offsets.end())
      std::copy_n(weights.data() + found->second, block.count, parameters_.data() + block.offset);
}

template <std::floating_point T>
void DarknetModel<T>::update_running_statistics(const Pass<T>& pass, double momentum) {
  std::size_t output = pass.logits.size(), normalised = 0;
  for (const LayerConfig& layer : config_.layers) normalised += layer.batch_normalize ? 1 : 0;
  if (pass.mode != Mode::training || pass.graph.size() != 1 ||
      pass.graph.front().output_count() != output + 2 * normalised)
    throw DomainError(
        "DarknetModel::update_running_statistics: not a training pass that takes the statistics of a batch");
  for (std::size_t i = 0; i < config_.layers.size(); ++i) {
    if (!config_.layers[i].batch_normalize) continue;
    const auto count = static_cast<double>(pass.images * shapes_[i].height * shapes_[i].width);
    const double unbias = count > 1 ? count / (count - 1) : 1;
    const auto move = [&](std::size_t first, double factor) {
      const T* const batch = pass.graph.front().output(output++);
      for (std::size_t c = 0; c < config_.layers[i].filters; ++c) {
        T& running = parameters_[first + c];
        running = static_cast<T>((1 - momentum) * static_cast<double>(running) +
                                 momentum * factor * static_cast<double>(batch[c]));
      }
    };
    move(layout_.layers[i].mean, 1);
    move(layout_.layers[i].variance, unbias);
  }
}
}  // namespace tapestry::detect

#pragma once
#include <algorithm>
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstring>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <string_view>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/core/random.hpp>
#include <tapestry/detect/kept_picture.hpp>
#include <tapestry/detect/network.hpp>
#include <tapestry/detect/network_config.hpp>
#include <tapestry/detect/network_description.hpp>
#include <tapestry/detect/parameter_layout.hpp>
#include <tapestry/detect/pass.hpp>
#include <tapestry/nn/pointwise.hpp>
#include <utility>
#include <vector>

namespace tapestry::detect::detail {

template <std::floating_point T>
void GraphCache<T>::compare(const Array<T, 1>& parameters) {
  if (!is_watched_) return;
  const bool is_same = made_from_.size() == parameters.size() &&
                       (parameters.size() == 0 || std::memcmp(made_from_.data(), parameters.data(),
                                                              parameters.size() * sizeof(T)) == 0);
  if (is_same) return;
  clear();
  made_from_ = parameters;
}

}  // namespace tapestry::detect::detail

namespace tapestry::detect {

template <std::floating_point T>
Network<T>::Network(NetworkConfig config, std::size_t input_height, std::size_t input_width)
    : config_(std::move(config)),
      height_(input_height == 0 ? config_.height : input_height),
      width_(input_width == 0 ? config_.width : input_width),
      shapes_(infer_shapes(config_, height_, width_)),
      layout_(parameter_layout(config_, shapes_)),
      parameters_(zeros<T, 1>({layout_.count})) {
  for (std::size_t i = 0; i < config_.layers.size(); ++i)
    if (is_head(config_.layers[i].kind)) heads_.push_back(detail::head_of(config_.layers[i], shapes_[i]));
  for (const ParameterBlock& block : layout_.blocks)
    if (block.role == ParameterRole::scale || block.role == ParameterRole::variance) fill(block, 1);
}

template <std::floating_point T>
Network<T>::Network(NetworkConfig config, Array<T, 1> parameters, std::size_t input_height,
                    std::size_t input_width)
    : Network(std::move(config), input_height, input_width) {
  require_shape("Network", "parameters", parameters, {layout_.count});
  parameters_ = std::move(parameters);
}

template <std::floating_point T>
SuppressionMeasure Network<T>::suppression_measure() const {
  SuppressionMeasure measure;
  for (const LayerConfig& layer : config_.layers)
    if (is_head(layer.kind)) measure.distance_exponent = layer.beta_nms;
  return measure;
}

template <std::floating_point T>
void Network<T>::initialise(Random& random) {
  for (const ParameterBlock& block : layout_.blocks) {
    fill(block, block.role == ParameterRole::scale || block.role == ParameterRole::variance ? T(1) : T(0));
    if (block.role != ParameterRole::weight) continue;
    const auto fan_in = static_cast<double>(block.count / config_.layers[block.layer].filters);
    const double deviation = std::sqrt(2 / fan_in);
    for (std::size_t i = 0; i < block.count; ++i)
      parameters_[block.offset + i] = static_cast<T>(deviation * random.normal());
  }
  graphs_.forget();
}

template <std::floating_point T>
Array<T, 1>& Network<T>::parameters() {
  graphs_.watch();
  return parameters_;
}

template <std::floating_point T>
void Network<T>::set_engine(nn::Engine engine) {
  engine_ = engine;
  graphs_ = {};
}

template <std::floating_point T>
Network<T> Network<T>::resized(std::size_t input_height, std::size_t input_width) const {
  Network other(config_, parameters_, input_height, input_width);
  other.images_seen_ = images_seen_;
  other.engine_ = engine_;
  other.layers_ = layers_;
  return other;
}

template <std::floating_point T>
void Network<T>::tell_layers(const std::vector<std::size_t>& layers) {
  const auto makers = makers_of_values(config_);
  std::vector<std::size_t> told;
  for (const std::size_t layer : layers) {
    if (layer >= makers.size() || makers[layer] == picture_value)
      throw FileError(ErrorKind::mismatch,
                      {config_.name, "", "layer " + std::to_string(layer) + " cannot be looked into",
                       "one that computes something, from 0 to " + std::to_string(makers.size() - 1)});
    told.push_back(makers[layer]);
  }
  layers_ = std::move(told);
  graphs_ = {};
}

template <std::floating_point T>
std::optional<std::size_t> Network<T>::common_layer() const {
  const auto makers = makers_of_values(config_);
  std::vector<std::size_t> results;  // layers whose values are handed out
  for (std::size_t i = 0; i < config_.layers.size(); ++i)
    if (is_head(config_.layers[i].kind)) results.push_back(makers[i]);
  if (results.empty()) results.push_back(makers.back());
  std::vector<std::size_t> readers(makers.size(), 0);  // results that are computed of each layer
  for (const std::size_t result : results) {
    std::vector<bool> is_needed(makers.size(), false);
    if (result != picture_value) is_needed[result] = true;
    for (std::size_t i = makers.size(); i-- > 0;) {
      if (makers[i] != i || !is_needed[i]) continue;
      if (i != result) ++readers[i];
      for (const std::size_t input : inputs_of(config_, i))
        if (makers[input] != picture_value) is_needed[makers[input]] = true;
    }
  }
  for (std::size_t i = makers.size(); i-- > 0;)
    if (readers[i] == results.size()) return i;
  return std::nullopt;
}

template <std::floating_point T>
std::unique_ptr<Detector<T>> Network<T>::make_graph(bool is_training) const {
  std::vector<std::string> layers;
  for (const std::size_t layer : layers_) layers.push_back("layer_" + std::to_string(layer));
  auto graph = std::make_unique<Detector<T>>(
      network_description(config_, parameters_, height_, width_, is_training), heads_, layers, !is_training);
  graph->set_engine(engine_);
  graph->set_fit(fit_of(config_));
  graph->set_suppression_measure(suppression_measure());
  return graph;
}

template <std::floating_point T>
std::shared_ptr<const Detector<T>> Network<T>::detector(Mode mode) const {
  const bool is_training = mode == Mode::training;
  return graphs_.get(
      is_training, parameters_, [&] { return make_graph(is_training); },
      [&](Detector<T>& graph) {
        auto constants = graph.network().constants();
        for_each_weight(graph, [&](std::size_t offset, const ParameterBlock& block) {
          std::copy_n(parameters_.data() + block.offset, block.count, constants.data() + offset);
        });
        graph.network().set_constants(constants);
      });
}

template <std::floating_point T>
template <class Body>
void Network<T>::for_each_weight(const Detector<T>& graph, Body body) const {
  std::map<std::string_view, std::size_t> offsets;
  for (const nn::WeightBlock& weight : graph.network().weights()) offsets[weight.name] = weight.offset;
  for (const ParameterBlock& block : layout_.blocks)
    if (const auto found = offsets.find(constant_name(block)); found != offsets.end())
      body(found->second, block);
}

template <std::floating_point T>
const Detector<T>& Network<T>::graph_of(const char* operation, const Pass<T>& pass) {
  if (!pass.ran_by)
    throw DomainError(std::string(operation) + ": the pass kept nothing; run forward() for a gradient first");
  return *static_cast<const Detector<T>*>(pass.ran_by.get());
}

template <std::floating_point T>
void Network<T>::forward(const Array<T, 4>& images, Pass<T>& pass, Mode mode) const {
  const auto graph = detector(mode);
  graph->forward(images, pass, mode);
  pass.ran_by = graph;
}

template <std::floating_point T>
void Network<T>::forward_within(const Array<T, 4>& images, const std::vector<KeptPicture<T>*>& kept,
                                Pass<T>& pass, Mode mode) const {
  const auto graph = detector(mode);
  graph->forward_within(images, kept, pass, mode);
  pass.ran_by = graph;
}

template <std::floating_point T>
double Network<T>::share_kept(const image::PixelWindow& window) const {
  return detector()->share_kept(window);
}

template <std::floating_point T>
Array<T, 3> Network<T>::layer_values(const Pass<T>& pass, std::size_t layer, std::size_t image) const {
  return graph_of("Detector::layer_values", pass).layer_values(pass, layer, image);
}

template <std::floating_point T>
Array<T, 3> Network<T>::layer_adjoint(Pass<T>& pass, const std::vector<const Array<T, 4>*>& logits_adjoint,
                                      std::size_t layer, std::size_t image) const {
  return graph_of("Detector::layer_adjoint", pass).layer_adjoint(pass, logits_adjoint, layer, image);
}

template <std::floating_point T>
void Network<T>::pull_back_layer(Pass<T>& pass, std::size_t layer, std::size_t image,
                                 const Array<T, 3>& layer_adjoint, Array<T, 4>& images_adjoint) const {
  graph_of("Detector::pull_back_layer", pass)
      .pull_back_layer(pass, layer, image, layer_adjoint, images_adjoint);
}

template <std::floating_point T>
void Network<T>::pull_back(Pass<T>& pass, const std::vector<const Array<T, 4>*>& logits_adjoint,
                           Array<T, 4>* images_adjoint, Array<T, 1>* parameters_adjoint) const {
  const Detector<T>& graph = graph_of("Detector::pull_back", pass);
  if (parameters_adjoint == nullptr) return graph.pull_back(pass, logits_adjoint, images_adjoint);
  if (pass.mode != Mode::training) throw DomainError("Detector::pull_back: the pass was not for training");
  require_shape("Detector::pull_back", "parameters_adjoint", *parameters_adjoint, {layout_.count});
  auto constants_adjoint = zeros<T, 1>({graph.network().constants().size()});
  graph.pull_back(pass, logits_adjoint, images_adjoint, &constants_adjoint);
  for_each_weight(graph, [&](std::size_t offset, const ParameterBlock& block) {
    nn::add(constants_adjoint.data() + offset, parameters_adjoint->data() + block.offset, block.count);
  });
}

template <std::floating_point T>
void Network<T>::input_adjoint(Pass<T>& pass, const std::vector<Array<T, 4>>& logits_adjoint,
                               Array<T, 4>& images_adjoint) const {
  graph_of("Detector::pull_back", pass).input_adjoint(pass, logits_adjoint, images_adjoint);
}

template <std::floating_point T>
void Network<T>::parameter_adjoint(Pass<T>& pass, const std::vector<Array<T, 4>>& logits_adjoint,
                                   Array<T, 1>& parameters_adjoint) const {
  std::vector<const Array<T, 4>*> pointers;
  for (const auto& array : logits_adjoint) pointers.push_back(&array);
  pull_back(pass, pointers, nullptr, &parameters_adjoint);
}

template <std::floating_point T>
void Network<T>::update_running_statistics(const Pass<T>& pass, double momentum) {
  if (pass.mode != Mode::training || pass.graph.size() != 1)
    throw DomainError("Network::update_running_statistics: not a training pass");
  std::size_t output = pass.logits.size();
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
  graphs_.forget();
}

template <std::floating_point T>
Network<T>::Network(const Network&) = default;

template <std::floating_point T>
Network<T>::Network(Network&&) noexcept = default;

template <std::floating_point T>
Network<T>& Network<T>::operator=(const Network&) = default;

template <std::floating_point T>
Network<T>& Network<T>::operator=(Network&&) noexcept = default;

template <std::floating_point T>
Network<T>::~Network() = default;

template class Network<float>;
template class Network<double>;

}  // namespace tapestry::detect

#pragma once
#include <cmath>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/random.hpp>
#include <tapestry/detect/detector.hpp>
#include <tapestry/detect/kept_picture.hpp>
#include <tapestry/detect/network.hpp>
#include <tapestry/detect/network/backward.hpp>
#include <tapestry/detect/network/forward.hpp>
#include <tapestry/detect/network/graph.hpp>
#include <tapestry/detect/network/kept_forward.hpp>
#include <tapestry/detect/network/pass.hpp>
#include <tapestry/detect/network/prepared_weights.hpp>
#include <tapestry/detect/network/told_layers.hpp>
#include <tapestry/detect/network_config.hpp>
#include <tapestry/detect/parameter_layout.hpp>
#include <tapestry/image/pixel_window.hpp>
#include <tapestry/nn/window.hpp>
#include <utility>
#include <vector>

namespace tapestry::detect {

template <std::floating_point T>
Network<T>::Network(NetworkConfig config, std::size_t input_height, std::size_t input_width)
    : graph_(detail::make_graph(std::move(config), input_height, input_width)),
      parameters_(zeros<T, 1>({graph_.layout.count})) {
  for (const ParameterBlock& block : graph_.layout.blocks)
    if (block.role == ParameterRole::scale || block.role == ParameterRole::variance) fill(block, 1);
}

template <std::floating_point T>
Network<T>::Network(NetworkConfig config, Array<T, 1> parameters, std::size_t input_height,
                    std::size_t input_width)
    : graph_(detail::make_graph(std::move(config), input_height, input_width)),
      parameters_(std::move(parameters)) {
  if (parameters_.size() != graph_.layout.count)
    throw ShapeError("Network: parameters is [" + std::to_string(parameters_.size()) + "], expected [" +
                     std::to_string(graph_.layout.count) + "]");
}

template <std::floating_point T>
SuppressionMeasure Network<T>::suppression_measure() const {
  SuppressionMeasure measure;
  for (const LayerConfig& layer : graph_.config.layers)
    if (is_head(layer.kind)) measure.distance_exponent = layer.beta_nms;
  return measure;
}

template <std::floating_point T>
void Network<T>::initialise(Random& random) {
  for (const ParameterBlock& block : graph_.layout.blocks) {
    fill(block, block.role == ParameterRole::scale || block.role == ParameterRole::variance ? T(1) : T(0));
    if (block.role != ParameterRole::weight) continue;
    const auto fan_in = static_cast<double>(block.count / graph_.config.layers[block.layer].filters);
    const double deviation = std::sqrt(2 / fan_in);
    for (std::size_t i = 0; i < block.count; ++i)
      parameters_[block.offset + i] = static_cast<T>(deviation * random.normal());
  }
  cache_.forget();
}

template <std::floating_point T>
Array<T, 3> Network<T>::layer_adjoint(Pass<T>& pass, const std::vector<const Array<T, 4>*>& logits_adjoint,
                                      std::size_t layer, std::size_t image) const {
  this->require_logits_adjoint("Network::layer_adjoint", pass,
                               pass.within.empty() && pass.layers.size() == graph_.image() + 1,
                               logits_adjoint);
  const auto weights = cache_.adjoint(graph_, parameters_, pass.mode != Mode::training);
  return detail::told_adjoint(detail::BackwardPass<T>(graph_, engine_, parameters_, *weights, pass), graph_,
                              pass, logits_adjoint, layer, image);
}

template <std::floating_point T>
void Network<T>::pull_back_layer(Pass<T>& pass, std::size_t layer, std::size_t image,
                                 const Array<T, 3>& layer_adjoint, Array<T, 4>& images_adjoint) const {
  const auto weights = cache_.adjoint(graph_, parameters_, pass.mode != Mode::training);
  detail::pull_back_told(detail::BackwardPass<T>(graph_, engine_, parameters_, *weights, pass), graph_, pass,
                         layer, image, layer_adjoint, images_adjoint);
}

template <std::floating_point T>
Array<T, 1>& Network<T>::parameters() {
  cache_.watch();
  return parameters_;
}

template <std::floating_point T>
Network<T> Network<T>::resized(std::size_t input_height, std::size_t input_width) const {
  Network other(graph_.config, input_height, input_width);
  other.parameters_ = parameters_;
  other.images_seen_ = images_seen_;
  other.engine_ = engine_;
  other.graph_.told = graph_.told;
  return other;
}

template <std::floating_point T>
void Network<T>::forward(const Array<T, 4>& images, Pass<T>& pass, Mode mode) const {
  this->require_images(images);
  const auto weights = cache_.forward(graph_, parameters_, mode != Mode::training);
  begin(pass, images.shape(0), mode);
  pass.within.clear();
  detail::ForwardPass<T>(graph_, engine_, parameters_, *weights, pass).run(images.data(), logits_of(pass, 0));
}

template <std::floating_point T>
void Network<T>::forward_within(const Array<T, 4>& images, const std::vector<KeptPicture<T>*>& kept,
                                Pass<T>& pass, Mode mode) const {
  this->require_images(images);
  require_kept("Network::forward_within", *this, images, kept);
  if (mode == Mode::training) return forward(images, pass, mode);
  const auto weights = cache_.forward(graph_, parameters_, true);
  begin(pass, images.shape(0), mode);
  pass.layers.clear();
  pass.within.resize(kept.size());
  for (std::size_t i = 0; i < kept.size(); ++i) {
    Pass<T>& own = pass.within[i];
    own.mode = mode;
    own.images = 1;
    const T* const image = images.data() + i * graph_.shapes.back().size();
    if (kept[i] != nullptr) {
      detail::forward_kept<T>(graph_, engine_, parameters_, cache_, weights, image,
                              rows_and_columns(kept[i]->window()), kept[i]->values(), own,
                              logits_of(pass, i));
    } else {
      own.plan = nullptr;
      own.window.reset();
      detail::ForwardPass<T>(graph_, engine_, parameters_, *weights, own).run(image, logits_of(pass, i));
    }
  }
}

template <std::floating_point T>
double Network<T>::share_kept(const image::PixelWindow& window) const {
  image::require_window("Network::share_kept", window, graph_.height, graph_.width);
  return detail::share_left_out(graph_, detail::plan_of(graph_, engine_, parameters_, cache_,
                                                        Mode::input_gradient, rows_and_columns(window)));
}

template <std::floating_point T>
void Network<T>::parameter_adjoint(Pass<T>& pass, const std::vector<Array<T, 4>>& logits_adjoint,
                                   Array<T, 1>& parameters_adjoint) const {
  std::vector<const Array<T, 4>*> pointers;
  for (const auto& array : logits_adjoint) pointers.push_back(&array);
  adjoints("Network::parameter_adjoint", pass, pointers, nullptr, &parameters_adjoint);
}

template <std::floating_point T>
void Network<T>::update_running_statistics(const Pass<T>& pass, double momentum) {
  if (pass.mode != Mode::training)
    throw DomainError("Network::update_running_statistics: not a training pass");
  for (std::size_t i = 0; i < graph_.config.layers.size(); ++i) {
    if (!graph_.config.layers[i].batch_normalize) continue;
    const auto& statistics = pass.layers[i].statistics;
    const auto count = static_cast<double>(pass.images * graph_.shapes[i].height * graph_.shapes[i].width);
    const double unbias = count > 1 ? count / (count - 1) : 1;
    const auto move = [&](T& running, double batch) {
      running = static_cast<T>((1 - momentum) * static_cast<double>(running) + momentum * batch);
    };
    for (std::size_t c = 0; c < statistics.mean.size(); ++c) {
      move(parameters_[graph_.layout.layers[i].mean + c], statistics.mean[c]);
      move(parameters_[graph_.layout.layers[i].variance + c], statistics.variance[c] * unbias);
    }
  }
  cache_.forget();
}

template <std::floating_point T>
void Network<T>::begin(Pass<T>& pass, std::size_t images, Mode mode) const {
  pass.mode = mode;
  pass.images = images;
  pass.logits.resize(graph_.head_values.size());
  for (std::size_t h = 0; h < pass.logits.size(); ++h) {
    const FeatureShape& shape = graph_.shapes[graph_.head_values[h]];
    pass.logits[h].resize({images, shape.channels, shape.height, shape.width});
  }
}

template <std::floating_point T>
std::vector<T*> Network<T>::logits_of(Pass<T>& pass, std::size_t image) {
  std::vector<T*> pointers;
  for (auto& logits : pass.logits) pointers.push_back(logits.data() + image * (logits.size() / pass.images));
  return pointers;
}

template <std::floating_point T>
void Network<T>::adjoints(const char* operation, Pass<T>& pass,
                          const std::vector<const Array<T, 4>*>& logits_adjoint, Array<T, 4>* images_adjoint,
                          Array<T, 1>* parameters_adjoint) const {
  const bool kept_something = pass.layers.size() == graph_.image() + 1 || !pass.within.empty();
  this->require_logits_adjoint(operation, pass, kept_something, logits_adjoint);
  if (images_adjoint != nullptr) {
    require_shape(operation, "images_adjoint", *images_adjoint,
                  {pass.images, graph_.height, graph_.width, graph_.config.channels});
  }
  if (parameters_adjoint != nullptr)
    detail::require_parameters_adjoint(operation, pass, parameters_adjoint->size(), parameters_.size());
  const auto weights = cache_.adjoint(graph_, parameters_, pass.mode != Mode::training);
  const auto run = [&](Pass<T>& own, std::size_t image) {
    std::vector<const T*> heads;
    for (const Array<T, 4>* head : logits_adjoint)
      heads.push_back(head == nullptr ? nullptr : head->data() + image * (head->size() / pass.images));
    detail::BackwardPass<T>(graph_, engine_, parameters_, *weights, own)
        .run(heads,
             images_adjoint == nullptr ? nullptr
                                       : images_adjoint->data() + image * graph_.shapes.back().size(),
             parameters_adjoint == nullptr ? nullptr : parameters_adjoint->data());
  };
  if (pass.within.empty()) return run(pass, 0);
  for (std::size_t i = 0; i < pass.within.size(); ++i) run(pass.within[i], i);
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

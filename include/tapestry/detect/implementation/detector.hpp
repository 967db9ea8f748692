#pragma once
#include <charconv>
#include <tapestry/detect/detector.hpp>
#include <tapestry/detect/implementation/detector/head_network.hpp>
#include <tapestry/detect/implementation/detector/passes.hpp>
#include <tapestry/detect/implementation/detector/stages.hpp>

namespace tapestry::detect {
namespace detail {
[[nodiscard]] inline bool takes_batch_statistics(const nn::NetworkDescription& network) {
  return std::ranges::any_of(network.nodes, [](const nn::Node& node) {
    const auto found = node.attributes.find("training_mode");
    if (node.operation != "BatchNormalization" || found == node.attributes.end()) return false;
    const auto* const mode = std::get_if<std::int64_t>(&found->second);
    return mode != nullptr && *mode != 0;
  });
}

/// Names in messages for the nodes that make these values.
[[nodiscard]] inline std::vector<std::string> labels_of(const nn::NetworkDescription& network,
                                                        const std::vector<std::string>& values) {
  std::vector<std::string> labels;
  for (const std::string& value : values) labels.push_back(nn::label_of(*nn::maker_of(network, value)));
  return labels;
}

/// A network with more outputs, which takes over its constants.
[[nodiscard]] inline nn::NetworkDescription with_outputs(nn::NetworkDescription& network,
                                                         const std::vector<std::string>& layers) {
  nn::NetworkDescription more{network.path, network.opset, network.inputs, network.outputs,
                              {},           network.nodes};
  more.constants = std::move(network.constants);
  more.outputs.insert(more.outputs.end(), layers.begin(), layers.end());
  return more;
}
}  // namespace detail

template <std::floating_point T>
Detector<T>::Detector(const nn::NetworkDescription& network, DetectorDescription kind, std::size_t size,
                      const std::vector<std::string>& layers, bool simplifies)
    : Detector(OfBatch{*detail::of_batch(network)}, std::move(kind), size, layers, simplifies) {}

template <std::floating_point T>
Detector<T>::Detector(OfBatch of, DetectorDescription kind, std::size_t size,
                      const std::vector<std::string>& layers, bool simplifies)
    : kind_(std::move(kind)),
      layer_count_(layers.size()),
      claim_(detail::claim_of(of.network.path, kind_)),
      network_(detail::network_of_heads<T>(
          of.network, kind_, picture_extents(of.network, size), simplifies, stages_,
          [&](bool lacks_axis) {
            return detail::showing_heads(of.network, kind_, size, layers, lacks_axis);
          })),
      shapes_(detail::first_shapes(network_, stages_.get(), kind_.decoded.most_candidates)),
      height_(network_.input_shape(0)[1]),
      width_(network_.input_shape(0)[2]),
      heads_(exported_heads(of.network.path, kind_, head_shapes(),
                            detail::labels_of(of.network, raw_outputs(of.network)), height_, width_)),
      trains_together_(detail::takes_batch_statistics(of.network)) {
  require_layers(of.network.path, layers);
}

template <std::floating_point T>
Detector<T>::Detector(nn::NetworkDescription network, std::vector<Head> heads,
                      const std::vector<std::string>& layers, bool simplifies)
    : layer_count_(layers.size()),
      network_(detail::with_outputs(network, layers), {}, true, simplifies),
      shapes_(detail::first_shapes<T>(network_, nullptr, 0)),
      height_(network_.input_shape(0)[1]),
      width_(network_.input_shape(0)[2]),
      heads_{std::move(heads), {}},
      trains_together_(detail::takes_batch_statistics(network)) {
  for (std::size_t h = 0; h < std::max<std::size_t>(1, heads_.heads.size()); ++h)
    heads_.pieces.push_back({h, h, 0, nn::size_of(shapes_.at(h))});
  for (std::size_t h = 0; h < heads_.heads.size(); ++h) {
    const Head& head = heads_.heads[h];
    const nn::Shape expected{1, head.channel_count(), head.grid_height, head.grid_width};
    if (shapes_.at(h) != expected)
      throw ShapeError({"Detector: output ", h, " is ", shapes_[h], ", expected ", expected});
  }
  require_layers(network.path, layers);
}

template <std::floating_point T>
std::size_t Detector<T>::class_index(std::string_view name) const {
  const auto found = std::ranges::find(names_, name);
  if (found != names_.end()) return static_cast<std::size_t>(found - names_.begin());
  const std::size_t classes = heads().empty() ? 0 : heads().front().classes;
  std::size_t index = 0;
  const auto [end, error] = std::from_chars(name.data(), name.data() + name.size(), index);
  const bool is_number = !name.empty() && error == std::errc{} && end == name.data() + name.size();
  if (is_number && index < classes) return index;
  if (!names_.empty()) {
    std::string list = listed(std::span(names_).first(std::min<std::size_t>(names_.size(), 20)));
    if (names_.size() > 20) list += ", … (" + std::to_string(names_.size()) + " in all)";
    throw Error(ErrorKind::mismatch, {"no class is named ", in_quotes(name), "; there are ", list});
  }
  if (!is_number)
    throw Error(ErrorKind::usage, {"class ", in_quotes(name),
                                   " needs the names of the classes; without them it must be a number"});
  throw Error(ErrorKind::mismatch, {"class ", name, ": the detector has ", classes, " classes"});
}

template <std::floating_point T>
Array<T, 4> Detector<T>::input(const Array<T, 3>& photograph) const {
  return image::batch_of(image::fitted(photograph, height_, width_, kind_.fit));
}

template <std::floating_point T>
std::vector<Detection> Detector<T>::detections(const std::vector<Array<T, 4>>& logits, std::size_t image,
                                               double confidence, double overlap) const {
  return suppress(decode(heads(), logits, image, confidence, height_, width_), overlap, true, measure_);
}

template <std::floating_point T>
std::vector<Detection> Detector<T>::in_photograph(std::vector<Detection> detections, std::size_t height,
                                                  std::size_t width) const {
  const auto back = image::picture_from_canvas(height, width, height_, width_, kind_.fit.kind);
  for (Detection& detection : detections) {
    Box& box = detection.box;
    box = {back.x(box.cx), back.y(box.cy), back.width(box.w), back.height(box.h)};
  }
  return detections;
}

template <std::floating_point T>
void Detector<T>::require_layers(const std::string& path, const std::vector<std::string>& layers) const {
  for (std::size_t layer = 0; layer < layer_count_; ++layer)
    if (const auto& shape = layer_shape(layer); shape.size() != 4 || shape[0] != 1)
      throw file_mismatch({path, "", "layer " + in_quotes(layers[layer]), "maps, [1, C, H, W]",
                           std::to_string(shape.size()) + " axes"});
}

template <std::floating_point T>
std::array<std::size_t, 3> Detector<T>::logits_extents(std::size_t head) const {
  if (!heads_.heads.empty())
    return {heads_.heads[head].channel_count(), heads_.heads[head].grid_height,
            heads_.heads[head].grid_width};
  const nn::Shape& shape = shapes_.front();
  return {shape.at(1), shape.at(2), shape.at(3)};
}

template <std::floating_point T>
Detector<T>::Detector(Detector&&) noexcept = default;

template <std::floating_point T>
Detector<T>& Detector<T>::operator=(Detector&&) noexcept = default;

template <std::floating_point T>
Detector<T>::~Detector() = default;
}  // namespace tapestry::detect

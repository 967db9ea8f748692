#pragma once
#include <algorithm>
#include <concepts>
#include <cstddef>
#include <map>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/detect/detector.hpp>
#include <tapestry/detect/detector_description.hpp>
#include <tapestry/detect/exported_heads.hpp>
#include <tapestry/detect/graph_detector.hpp>
#include <tapestry/detect/input_encoding.hpp>
#include <tapestry/detect/kept_picture.hpp>
#include <tapestry/detect/raw_outputs.hpp>
#include <tapestry/nn/network/network.hpp>
#include <tapestry/nn/network/pruned.hpp>
#include <tapestry/nn/window.hpp>
#include <utility>
#include <vector>

namespace tapestry::detect {

template <std::floating_point T>
GraphDetector<T>::GraphDetector(const nn::NetworkDescription& network, DetectorDescription kind,
                                std::size_t size, const std::vector<std::string>& layers, bool simplifies)
    : kind_(std::move(kind)),
      layer_count_(layers.size()),
      network_(showing_heads(network, kind_, size, layers), sizes(network, size), true, simplifies),
      heads_(exported_heads(network.path, kind_, output_shapes(), input_height(), input_width())) {
  for (std::size_t layer = 0; layer < layer_count_; ++layer)
    if (const auto& shape = layer_shape(layer); shape.size() != 4 || shape[0] != 1)
      throw FileError(ErrorKind::mismatch, {network.path, "", "layer " + in_quotes(layers[layer]),
                                            "maps, [1, C, H, W]", std::to_string(shape.size()) + " axes"});
}

template <std::floating_point T>
Array<T, 3> GraphDetector<T>::layer_values(const Pass<T>& pass, std::size_t layer, std::size_t image) const {
  const auto& shape = layer_shape(layer);
  Array<T, 3> values(Extents<3>{shape[1], shape[2], shape[3]});
  std::copy_n(pass.graph.at(image).output(head_output_count() + layer), values.size(), values.data());
  return values;
}

template <std::floating_point T>
void GraphDetector<T>::require_whole(const char* operation, const Pass<T>& pass) {
  const auto is_within = [](const nn::NetworkPass<T>& one) { return one.is_within(); };
  if (pass.mode == Mode::inference || pass.graph.size() != pass.images ||
      std::ranges::any_of(pass.graph, is_within))
    throw DomainError(std::string(operation) +
                      ": the pass kept nothing, or only windows; run forward() for a gradient first");
}

template <std::floating_point T>
Array<T, 3> GraphDetector<T>::layer_adjoint(Pass<T>& pass,
                                            const std::vector<const Array<T, 4>*>& logits_adjoint,
                                            std::size_t layer, std::size_t image) const {
  require_whole("GraphDetector::layer_adjoint", pass);
  this->require_logits_adjoint("GraphDetector::layer_adjoint", pass, true, logits_adjoint);
  const auto& shape = layer_shape(layer);
  auto adjoint = zeros<T, 3>({shape[1], shape[2], shape[3]});
  std::vector<T*> gathered(network_.output_count(), nullptr);
  gathered[head_output_count() + layer] = adjoint.data();
  nn::Buffer<T> input_adjoint;
  input_adjoint.resize(image_size());
  input_adjoint.fill_zero();
  network_.adjoint(pass.graph.at(image), adjoints_of_outputs(logits_adjoint, image), {input_adjoint.data()},
                   nullptr, gathered);
  return adjoint;
}

template <std::floating_point T>
void GraphDetector<T>::pull_back_layer(Pass<T>& pass, std::size_t layer, std::size_t image,
                                       const Array<T, 3>& layer_adjoint, Array<T, 4>& images_adjoint) const {
  require_whole("GraphDetector::pull_back_layer", pass);
  const auto& shape = layer_shape(layer);
  require_shape("GraphDetector::pull_back_layer", "layer_adjoint", layer_adjoint,
                {shape[1], shape[2], shape[3]});
  require_shape("GraphDetector::pull_back_layer", "images_adjoint", images_adjoint,
                {pass.images, input_height(), input_width(), 3});
  std::vector<const T*> asked(network_.output_count(), nullptr);
  asked[head_output_count() + layer] = layer_adjoint.data();
  nn::Buffer<T> input_adjoint;
  input_adjoint.resize(image_size());
  input_adjoint.fill_zero();
  network_.adjoint(pass.graph.at(image), asked, {input_adjoint.data()}, nullptr);
  encode_adjoint(input_adjoint.data(), image_size() / 3, kind_.encoding,
                 images_adjoint.data() + image * image_size());
}

template <std::floating_point T>
void GraphDetector<T>::forward(const Array<T, 4>& images, Pass<T>& pass, Mode mode) const {
  this->require_images(images);
  run(images, std::vector<KeptPicture<T>*>(images.shape(0), nullptr), pass, mode);
}

template <std::floating_point T>
void GraphDetector<T>::forward_within(const Array<T, 4>& images, const std::vector<KeptPicture<T>*>& kept,
                                      Pass<T>& pass, Mode mode) const {
  this->require_images(images);
  require_kept("GraphDetector::forward_within", *this, images, kept);
  run(images, kept, pass, mode);
}

template <std::floating_point T>
double GraphDetector<T>::share_kept(const image::PixelWindow& window) const {
  image::require_window("GraphDetector::share_kept", window, input_height(), input_width());
  return network_.share_kept(rows_and_columns(window));
}

template <std::floating_point T>
void GraphDetector<T>::run(const Array<T, 4>& images, const std::vector<KeptPicture<T>*>& kept, Pass<T>& pass,
                           Mode mode) const {
  pass.mode = mode;
  pass.images = images.shape(0);
  pass.graph.resize(pass.images);
  pass.inputs.resize(pass.images);
  pass.logits.resize(heads().size());
  for (std::size_t h = 0; h < heads().size(); ++h)
    pass.logits[h].resize(
        {pass.images, heads()[h].channel_count(), heads()[h].grid_height, heads()[h].grid_width});
  for (std::size_t n = 0; n < pass.images; ++n) {
    pass.inputs[n].resize(image_size());
    encode(images.data() + n * image_size(), image_size() / 3, kind_.encoding, pass.inputs[n].data());
    const T* const picture = pass.inputs[n].data();
    if (kept[n] == nullptr) {
      network_.forward({picture}, pass.graph[n], mode);
    } else {
      network_.forward_within(picture, rows_and_columns(kept[n]->window()), kept[n]->graph_values(),
                              pass.graph[n], mode);
    }
    for (const HeadPiece& piece : heads_.pieces)
      std::copy_n(pass.graph[n].output(piece.output), piece.size, at(piece, pass.logits[piece.head], n));
  }
}

template <std::floating_point T>
void GraphDetector<T>::pull_back(Pass<T>& pass, const std::vector<const Array<T, 4>*>& logits_adjoint,
                                 Array<T, 4>* images_adjoint, Array<T, 1>* parameters_adjoint) const {
  this->require_logits_adjoint("GraphDetector::pull_back", pass, pass.graph.size() == pass.images,
                               logits_adjoint);
  if (images_adjoint != nullptr)
    require_shape("GraphDetector::pull_back", "images_adjoint", *images_adjoint,
                  {pass.images, input_height(), input_width(), 3});
  if (parameters_adjoint != nullptr)
    require_shape("GraphDetector::pull_back", "parameters_adjoint", *parameters_adjoint,
                  {network_.constants().size()});
  nn::Buffer<T> input_adjoint;
  for (std::size_t n = 0; n < pass.images; ++n) {
    if (images_adjoint != nullptr) {
      input_adjoint.resize(image_size());
      input_adjoint.fill_zero();
    }
    network_.adjoint(pass.graph[n], adjoints_of_outputs(logits_adjoint, n),
                     {images_adjoint != nullptr ? input_adjoint.data() : nullptr},
                     parameters_adjoint == nullptr ? nullptr : parameters_adjoint->data());
    if (images_adjoint != nullptr)
      encode_adjoint(input_adjoint.data(), image_size() / 3, kind_.encoding,
                     images_adjoint->data() + n * image_size());
  }
}

template <std::floating_point T>
std::map<std::string, nn::Shape> GraphDetector<T>::sizes(const nn::NetworkDescription& network,
                                                         std::size_t size) {
  const auto refuse = [&](const std::string& found) {
    throw FileError(ErrorKind::mismatch,
                    {network.path, "", "not a detector of pictures", "one input [1, 3, H, W]", found});
  };
  if (network.inputs.size() != 1) refuse(std::to_string(network.inputs.size()) + " inputs");
  const auto& shape = network.inputs.front().shape;
  if (shape.size() != 4 || shape[1].value_or(3) != 3 || shape[0].value_or(1) != 1)
    refuse("input " + in_quotes(network.inputs.front().name) + " of other extents");
  if (size == 0 && (!shape[2] || !shape[3]))
    throw FileError(ErrorKind::mismatch,
                    {network.path, "", "the input's size is open; state it with --size"});
  return {{network.inputs.front().name, {1, 3, size == 0 ? *shape[2] : size, size == 0 ? *shape[3] : size}}};
}

template <std::floating_point T>
void GraphDetector<T>::require_value(const nn::NetworkDescription& network, const std::string& what,
                                     const std::string& name) {
  const auto makes = [&](const nn::Node& node) { return std::ranges::count(node.outputs, name) > 0; };
  if (std::ranges::none_of(network.nodes, makes))
    throw FileError(ErrorKind::mismatch,
                    {network.path, "", "no node makes the " + what + " " + in_quotes(name)});
}

template <std::floating_point T>
nn::NetworkDescription GraphDetector<T>::showing_heads(const nn::NetworkDescription& network,
                                                       const DetectorDescription& kind, std::size_t size,
                                                       const std::vector<std::string>& layers) {
  for (const std::string& layer : layers) require_value(network, "layer", layer);
  if (kind.head != HeadKind::boxes_and_scores) {
    auto outputs = raw_outputs(network);
    outputs.insert(outputs.end(), layers.begin(), layers.end());
    return nn::pruned(network, std::move(outputs));
  }
  require_value(network, "output", kind.decoded.boxes);
  require_value(network, "output", kind.decoded.scores);
  const auto input = sizes(network, size).begin()->second;
  auto shown = network;
  std::vector<std::string> outputs{add_decoded_outputs(shown, kind.decoded, input[2], input[3])};
  outputs.insert(outputs.end(), layers.begin(), layers.end());
  return nn::pruned(std::move(shown), std::move(outputs));
}

template <std::floating_point T>
std::vector<nn::Shape> GraphDetector<T>::output_shapes() const {
  std::vector<nn::Shape> shapes;
  for (std::size_t i = 0; i < head_output_count(); ++i) shapes.push_back(network_.output_shape(i));
  return shapes;
}

template <std::floating_point T>
std::vector<const T*> GraphDetector<T>::adjoints_of_outputs(
    const std::vector<const Array<T, 4>*>& logits_adjoint, std::size_t image) const {
  std::vector<const T*> of_outputs(network_.output_count(), nullptr);
  for (const HeadPiece& piece : heads_.pieces)
    if (const Array<T, 4>* adjoint = logits_adjoint[piece.head]; adjoint != nullptr)
      of_outputs[piece.output] = at(piece, *adjoint, image);
  return of_outputs;
}

template <std::floating_point T>
GraphDetector<T>::GraphDetector(GraphDetector&&) noexcept = default;

template <std::floating_point T>
GraphDetector<T>& GraphDetector<T>::operator=(GraphDetector&&) noexcept = default;

template <std::floating_point T>
GraphDetector<T>::~GraphDetector() = default;

template class GraphDetector<float>;
template class GraphDetector<double>;

}  // namespace tapestry::detect

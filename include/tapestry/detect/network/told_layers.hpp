#pragma once
#include <cstddef>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/detect/network/backward.hpp>
#include <tapestry/detect/network/graph.hpp>
#include <tapestry/detect/network/pass.hpp>
#include <tapestry/nn/layout.hpp>
#include <utility>
#include <vector>

namespace tapestry::detect::detail {

/// See Network::tell_layers().
inline void tell_layers(Graph& graph, const std::vector<std::size_t>& layers) {
  std::vector<std::size_t> told;
  for (const std::size_t layer : layers) {
    if (layer >= graph.image() || graph.value_of[layer] == graph.image())
      throw FileError(ErrorKind::mismatch,
                      {graph.config.name, "", "layer " + std::to_string(layer) + " cannot be looked into",
                       "one that computes something, from 0 to " + std::to_string(graph.image() - 1)});
    told.push_back(graph.value_of[layer]);
  }
  graph.told = told;
}

/// The value that a told layer makes. \throws DomainError if there is no such layer
[[nodiscard]] inline std::size_t told_value(const Graph& graph, std::size_t layer) {
  if (layer >= graph.told.size())
    throw DomainError("Network: layer " + std::to_string(layer) + " of the " +
                      std::to_string(graph.told.size()) + " that tell_layers() named");
  return graph.told[layer];
}

/// A value of one image, [C, H, W], from those of all, [N, H, W, C]; zeros if there are none.
/// \throws DomainError if there is no such image
template <class T>
[[nodiscard]] Array<T, 3> one_image(const FeatureShape& shape, std::size_t image, const nn::Buffer<T>& all) {
  auto one = zeros<T, 3>({shape.channels, shape.height, shape.width});
  if (all.empty()) return one;
  if ((image + 1) * one.size() > all.size())
    throw DomainError("Network: image " + std::to_string(image) + " of a smaller batch");
  nn::channels_first(1, shape.channels, shape.height * shape.width, all.data() + image * one.size(),
                     one.data());
  return one;
}

/// What a told layer holds for one image, [C, H, W].
/// \throws DomainError if the pass kept nothing
template <class T>
[[nodiscard]] Array<T, 3> told_values(const Graph& graph, const Pass<T>& pass, std::size_t layer,
                                      std::size_t image) {
  const std::size_t value = told_value(graph, layer);
  if (pass.mode == Mode::inference || pass.layers.size() != graph.image() + 1 || !pass.within.empty())
    throw DomainError("Network::layer_values: the pass kept nothing; run forward() for a gradient first");
  return one_image(graph.shapes[value], image, pass.layers[value].output);
}

/// What logits_adjoint asks of a told layer for one image, [C, H, W].
template <class T>
[[nodiscard]] Array<T, 3> told_adjoint(BackwardPass<T> backward, const Graph& graph, Pass<T>& pass,
                                       const std::vector<const Array<T, 4>*>& logits_adjoint,
                                       std::size_t layer, std::size_t image) {
  const std::size_t value = told_value(graph, layer);
  std::vector<const T*> heads;
  for (const Array<T, 4>* head : logits_adjoint) heads.push_back(head == nullptr ? nullptr : head->data());
  auto asked = backward.adjoint_of(value, heads);
  auto adjoint = one_image(graph.shapes[value], image, asked);
  pass.workspace.give(std::move(asked));
  return adjoint;
}

/// Adds to images_adjoint, [N, H, W, C], what the adjoint of a told layer for one image asks of it.
/// \throws ShapeError unless layer_adjoint is [C, H, W] of the layer, and images_adjoint as the images;
///         DomainError if there is no such image, or the pass kept nothing
template <class T>
void pull_back_told(BackwardPass<T> backward, const Graph& graph, Pass<T>& pass, std::size_t layer,
                    std::size_t image, const Array<T, 3>& layer_adjoint, Array<T, 4>& images_adjoint) {
  if (pass.mode == Mode::inference || !pass.within.empty() || pass.layers.size() != graph.image() + 1)
    throw DomainError("Network::pull_back_layer: the pass kept nothing; run forward() for a gradient first");
  require_shape("Network::pull_back_layer", "images_adjoint", images_adjoint,
                {pass.images, graph.height, graph.width, graph.config.channels});
  const std::size_t value = told_value(graph, layer);
  const FeatureShape& shape = graph.shapes[value];
  require_shape("Network::pull_back_layer", "layer_adjoint", layer_adjoint,
                {shape.channels, shape.height, shape.width});
  if (image >= pass.images)
    throw DomainError("Network: image " + std::to_string(image) + " of a smaller batch");
  auto all = pass.workspace.take(pass.images * layer_adjoint.size());
  all.fill_zero();
  nn::channels_last(1, shape.channels, shape.height * shape.width, layer_adjoint.data(),
                    all.data() + image * layer_adjoint.size());
  backward.run_from(value, std::move(all), images_adjoint.data());
}

}  // namespace tapestry::detect::detail

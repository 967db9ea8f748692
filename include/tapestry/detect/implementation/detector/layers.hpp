#pragma once
#include <algorithm>
#include <concepts>
#include <cstddef>
#include <string>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <tapestry/core/error.hpp>
#include <tapestry/detect/detector.hpp>
#include <vector>

namespace tapestry::detect {

template <std::floating_point T>
void Detector<T>::require_layer(const char* operation, const Pass<T>& pass, std::size_t layer,
                                std::size_t image) const {
  if (layer >= layer_count_)
    throw DomainError(std::string(operation) + ": layer " + std::to_string(layer) + " of the " +
                      std::to_string(layer_count_) + " that were named");
  if (image >= pass.images)
    throw DomainError(std::string(operation) + ": image " + std::to_string(image) + " of a batch of " +
                      std::to_string(pass.images));
}

template <std::floating_point T>
void Detector<T>::require_whole(const char* operation, const Pass<T>& pass) {
  const auto is_within = [](const nn::NetworkPass<T>& one) { return one.is_within(); };
  if (pass.mode == Mode::inference || pass.graph.empty() || std::ranges::any_of(pass.graph, is_within))
    throw DomainError(std::string(operation) +
                      ": the pass kept nothing, or only windows; run forward() for a gradient first");
}

template <std::floating_point T>
Array<T, 3> Detector<T>::layer_values(const Pass<T>& pass, std::size_t layer, std::size_t image) const {
  require_whole("Detector::layer_values", pass);
  require_layer("Detector::layer_values", pass, layer, image);
  const auto& shape = layer_shape(layer);
  Array<T, 3> values(Extents<3>{shape[1], shape[2], shape[3]});
  const std::size_t each = images_a_pass(pass);
  std::copy_n(pass.graph[image / each].output(head_output_count() + layer) + image % each * values.size(),
              values.size(), values.data());
  return values;
}

template <std::floating_point T>
Array<T, 3> Detector<T>::layer_adjoint(Pass<T>& pass, const std::vector<const Array<T, 4>*>& logits_adjoint,
                                       std::size_t layer, std::size_t image) const {
  require_whole("Detector::layer_adjoint", pass);
  require_logits_adjoint("Detector::layer_adjoint", pass, logits_adjoint);
  require_layer("Detector::layer_adjoint", pass, layer, image);
  const auto& shape = layer_shape(layer);
  auto adjoint = zeros<T, 3>({shape[1], shape[2], shape[3]});
  const std::size_t each = images_a_pass(pass), n = image / each;
  std::vector<T> of_all(each * adjoint.size(), T(0));
  std::vector<T*> gathered(network_.output_count(), nullptr);
  gathered[head_output_count() + layer] = of_all.data();
  const auto adjoints = output_adjoints(pass, n, logits_adjoint);
  auto ignored = zeros<T, 4>({pass.images, height_, width_, input_channels()});
  pull_back_one(pass, n, adjoints.of_outputs, &ignored, nullptr, gathered);
  std::copy_n(of_all.data() + image % each * adjoint.size(), adjoint.size(), adjoint.data());
  return adjoint;
}

template <std::floating_point T>
void Detector<T>::pull_back_layer(Pass<T>& pass, std::size_t layer, std::size_t image,
                                  const Array<T, 3>& layer_adjoint, Array<T, 4>& images_adjoint) const {
  require_whole("Detector::pull_back_layer", pass);
  require_layer("Detector::pull_back_layer", pass, layer, image);
  const auto& shape = layer_shape(layer);
  require_shape("Detector::pull_back_layer", "layer_adjoint", layer_adjoint, {shape[1], shape[2], shape[3]});
  require_shape("Detector::pull_back_layer", "images_adjoint", images_adjoint,
                {pass.images, height_, width_, input_channels()});
  const std::size_t each = images_a_pass(pass);
  std::vector<T> of_all(each * layer_adjoint.size(), T(0));
  std::copy_n(layer_adjoint.data(), layer_adjoint.size(),
              of_all.data() + image % each * layer_adjoint.size());
  std::vector<const T*> asked(network_.output_count(), nullptr);
  asked[head_output_count() + layer] = of_all.data();
  pull_back_one(pass, image / each, asked, &images_adjoint, nullptr);
}

}  // namespace tapestry::detect

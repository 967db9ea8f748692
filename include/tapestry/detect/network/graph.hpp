#pragma once
#include <algorithm>
#include <cstddef>
#include <optional>
#include <tapestry/detect/head.hpp>
#include <tapestry/detect/network_config.hpp>
#include <tapestry/detect/parameter_layout.hpp>
#include <tapestry/nn/convolution_geometry.hpp>
#include <tapestry/nn/pooling.hpp>
#include <tapestry/nn/reorg.hpp>
#include <tapestry/nn/scaling.hpp>
#include <vector>

namespace tapestry::detect::detail {

/// A network at one input size, with layers that only pass something on (dropout, heads, a route of one
/// whole layer) seen through. Values are numbered by the layer that makes them; the image comes last.
struct Graph {
  NetworkConfig config;
  std::size_t height = 0;
  std::size_t width = 0;
  std::vector<FeatureShape> shapes{};              ///< of each value, the image included
  std::vector<std::size_t> value_of{};             ///< the value that a layer's output is
  std::vector<std::vector<std::size_t>> inputs{};  ///< values that each layer reads
  std::vector<std::size_t> first_use{};            ///< layer that reads each value first
  std::vector<std::size_t> last_use{};             ///< and last; 0 if none does
  std::vector<bool> is_multiplied{};               ///< a product reads it, whose adjoint needs the value
  std::vector<std::size_t> told{};                 ///< values of which Network tells what they hold
  ParameterLayout layout{};
  std::vector<Head> heads{};
  std::vector<std::size_t> head_values{};  ///< the value that each head's logits are; without heads the last
                                           ///< layer's alone

  [[nodiscard]] std::size_t image() const { return config.layers.size(); }
  [[nodiscard]] bool is_told(std::size_t value) const { return std::ranges::count(told, value) > 0; }
  [[nodiscard]] bool makes_value(std::size_t layer) const { return value_of[layer] == layer; }

  /// Whether a layer's input, or of a network without heads the last layer's output, is handed out.
  [[nodiscard]] bool hands_out(std::size_t layer) const {
    return heads.empty() ? layer + 1 == config.layers.size() : is_head(config.layers[layer].kind);
  }

  /// Whether shortcut i adds all of a value to all of its own, and not only channels and pixels that both
  /// have.
  [[nodiscard]] bool is_whole(std::size_t i, std::size_t value) const {
    const FeatureShape &own = shapes[i], &other = shapes[value];
    return other.channels == own.channels && other.height == own.height && other.width == own.width;
  }

  [[nodiscard]] nn::ConvolutionShape convolution(std::size_t i) const {
    const LayerConfig& layer = config.layers[i];
    const FeatureShape& in = shapes[inputs[i].front()];
    return nn::square_convolution(in.height, in.width, in.channels, layer.filters, layer.size, layer.stride,
                                  layer.padding, layer.dilation, layer.groups);
  }

  [[nodiscard]] nn::PoolingShape pooling(std::size_t i) const {
    const LayerConfig& layer = config.layers[i];
    const FeatureShape& in = shapes[inputs[i].front()];
    const FeatureShape& out = shapes[i];
    return {in.height,   in.width,   out.height,   out.width,
            in.channels, layer.size, layer.stride, layer.padding / 2};
  }

  /// What a product's factors multiply.
  [[nodiscard]] nn::FactorOf factors(std::size_t i) const {
    if (config.layers[i].kind == LayerKind::sam) return nn::FactorOf::values;
    return config.layers[i].scale_wh ? nn::FactorOf::pixels : nn::FactorOf::channels;
  }

  [[nodiscard]] nn::ReorgShape reorganisation(std::size_t i) const {
    const FeatureShape& in = shapes[inputs[i].front()];
    return {
        in.height, in.width, in.channels, config.layers[i].stride,
        config.layers[i].kind == LayerKind::reorg ? nn::ReorgOrder::darknet : nn::ReorgOrder::space_to_depth};
  }
};

/// \throws FileError as infer_shapes()
[[nodiscard]] inline Graph make_graph(NetworkConfig config, std::size_t height, std::size_t width) {
  Graph graph;
  graph.config = std::move(config);
  graph.height = height == 0 ? graph.config.height : height;
  graph.width = width == 0 ? graph.config.width : width;
  graph.shapes = infer_shapes(graph.config, graph.height, graph.width);
  graph.layout = parameter_layout(graph.config, graph.shapes);
  graph.shapes.push_back({graph.config.channels, graph.height, graph.width});
  const std::size_t count = graph.config.layers.size();
  graph.first_use.assign(count + 1, count);
  graph.last_use.assign(count + 1, 0);
  graph.is_multiplied.assign(count + 1, false);
  for (std::size_t i = 0; i < count; ++i) {
    const LayerConfig& layer = graph.config.layers[i];
    std::vector<std::size_t> inputs;
    for (const std::size_t input : inputs_of(graph.config, i)) inputs.push_back(graph.value_of[input]);
    if (inputs.empty()) inputs.push_back(graph.image());
    const bool passes_on = layer.kind == LayerKind::dropout || is_head(layer.kind) ||
                           (layer.kind == LayerKind::route && inputs.size() == 1 && layer.groups == 1);
    graph.value_of.push_back(passes_on ? inputs.front() : i);
    if (is_head(layer.kind)) {
      graph.heads.push_back(head_of(layer, graph.shapes[i]));
      graph.head_values.push_back(inputs.front());
    }
    for (const std::size_t input : inputs) {
      if (passes_on && !is_head(layer.kind)) break;  // its readers count
      graph.first_use[input] = std::min(graph.first_use[input], i);
      graph.last_use[input] = i;
      if (is_product(layer.kind)) graph.is_multiplied[input] = true;
    }
    graph.inputs.push_back(std::move(inputs));
  }
  if (graph.heads.empty() && count > 0) {
    const std::size_t last = graph.value_of.back();
    graph.head_values.push_back(last);
    graph.first_use[last] = std::min(graph.first_use[last], count - 1);
    graph.last_use[last] = count - 1;
  }
  return graph;
}

/// The last value of which all that is handed out is computed; nothing if that is the picture alone.
[[nodiscard]] inline std::optional<std::size_t> common_value(const Graph& graph) {
  std::vector<std::size_t> readers(graph.image() + 1, 0);  // results that are computed of each value
  for (const std::size_t result : graph.head_values) {
    std::vector<bool> is_needed(graph.image() + 1, false);
    is_needed[result] = true;
    for (std::size_t i = graph.image(); i-- > 0;) {
      if (!graph.makes_value(i) || !is_needed[i]) continue;
      if (i != result) ++readers[i];
      for (const std::size_t input : graph.inputs[i]) is_needed[input] = true;
    }
  }
  for (std::size_t i = graph.image(); i-- > 0;)
    if (readers[i] == graph.head_values.size() && readers[i] > 0) return i;
  return std::nullopt;
}

}  // namespace tapestry::detect::detail

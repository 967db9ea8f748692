#pragma once
#include <cmath>
#include <cstddef>
#include <cstring>
#include <memory>
#include <mutex>
#include <tapestry/core/array.hpp>
#include <tapestry/detect/network/graph.hpp>
#include <tapestry/nn/batch_norm.hpp>
#include <tapestry/nn/packed_convolution.hpp>
#include <vector>

namespace tapestry::detect::detail {

/// Weights in the kernels' layout, for each layer; empty for layers that have none.
template <class T>
struct ForwardWeights {
  std::vector<nn::PackedConvolution<T>> convolutions{};
  std::vector<nn::Buffer<T>> biases{};
};

template <class T>
struct AdjointWeights {
  std::vector<std::vector<nn::PackedConvolution<T>>> convolutions{};
};

/// Factor that batch normalisation with running statistics puts on a filter: scale / √(variance + ε).
template <class T>
[[nodiscard]] double folded_factor(const Array<T, 1>& parameters, const ConvolutionParameters& own,
                                   std::size_t filter, double epsilon) {
  return static_cast<double>(parameters[own.scale + filter]) /
         std::sqrt(static_cast<double>(parameters[own.variance + filter]) + epsilon);
}

/// Calls pack(layer, shape, weight_at) for each convolution, where weight_at(i) is its i-th weight, times
/// the batch normalisation's factor if that is to be folded in.
template <class T, class Pack>
void for_each_convolution(const Graph& graph, const Array<T, 1>& parameters, bool folds, Pack pack) {
  for (std::size_t i = 0; i < graph.config.layers.size(); ++i) {
    if (graph.config.layers[i].kind != LayerKind::convolutional) continue;
    const nn::ConvolutionShape shape = graph.convolution(i);
    const ConvolutionParameters& own = graph.layout.layers[i];
    const T* weights = parameters.data() + own.weight;
    if (!folds || !graph.config.layers[i].batch_normalize) {
      pack(i, shape, [weights](std::size_t w) { return weights[w]; });
      continue;
    }
    const std::size_t filter_size = shape.group_in() * shape.taps();
    std::vector<double> factors;
    for (std::size_t m = 0; m < shape.out_channels; ++m)
      factors.push_back(folded_factor(parameters, own, m, graph.config.batch_norm_epsilon));
    pack(i, shape, [&](std::size_t w) { return static_cast<double>(weights[w]) * factors[w / filter_size]; });
  }
}

template <class T>
[[nodiscard]] ForwardWeights<T> prepare_forward(const Graph& graph, const Array<T, 1>& parameters,
                                                bool folds) {
  ForwardWeights<T> prepared;
  prepared.convolutions.resize(graph.config.layers.size());
  prepared.biases.resize(graph.config.layers.size());
  for_each_convolution(graph, parameters, folds,
                       [&](std::size_t i, const nn::ConvolutionShape& shape, auto weight_at) {
                         prepared.convolutions[i] = nn::pack_convolution<T>(shape, weight_at);
                         const ConvolutionParameters& own = graph.layout.layers[i];
                         nn::Buffer<T>& bias = prepared.biases[i];
                         bias.resize(shape.out_channels);
                         for (std::size_t m = 0; m < shape.out_channels; ++m) {
                           auto shift = static_cast<double>(parameters[own.bias + m]);
                           if (graph.config.layers[i].batch_normalize)
                             shift -= static_cast<double>(parameters[own.mean + m]) *
                                      folded_factor(parameters, own, m, graph.config.batch_norm_epsilon);
                           bias.data()[m] = static_cast<T>(shift);
                         }
                       });
  return prepared;
}

template <class T>
[[nodiscard]] AdjointWeights<T> prepare_adjoint(const Graph& graph, const Array<T, 1>& parameters,
                                                bool folds) {
  AdjointWeights<T> prepared;
  prepared.convolutions.resize(graph.config.layers.size());
  for_each_convolution(graph, parameters, folds,
                       [&](std::size_t i, const nn::ConvolutionShape& shape, auto weight_at) {
                         prepared.convolutions[i] = nn::pack_convolution_adjoint<T>(shape, weight_at);
                       });
  return prepared;
}

/// Prepares weights when they are first needed, and again when the parameters have changed. Copies of a
/// network prepare their own. May be called from several threads.
template <class T>
class WeightCache {
 public:
  WeightCache() = default;
  WeightCache(const WeightCache&) {}
  WeightCache& operator=(const WeightCache&) {
    forget();
    return *this;
  }

  /// From now on the owner may change the parameters unseen, so compare them before each use.
  void watch() { is_watched_ = true; }

  void forget() {
    const std::lock_guard<std::mutex> lock(mutex_);
    clear();
  }

  [[nodiscard]] std::shared_ptr<const ForwardWeights<T>> forward(const Graph& graph,
                                                                 const Array<T, 1>& parameters, bool folds) {
    const std::lock_guard<std::mutex> lock(mutex_);
    compare(parameters);
    auto& kept = forward_[folds ? 1 : 0];
    if (!kept) kept = std::make_shared<const ForwardWeights<T>>(prepare_forward(graph, parameters, folds));
    return kept;
  }

  [[nodiscard]] std::shared_ptr<const AdjointWeights<T>> adjoint(const Graph& graph,
                                                                 const Array<T, 1>& parameters, bool folds) {
    const std::lock_guard<std::mutex> lock(mutex_);
    compare(parameters);
    auto& kept = adjoint_[folds ? 1 : 0];
    if (!kept) kept = std::make_shared<const AdjointWeights<T>>(prepare_adjoint(graph, parameters, folds));
    return kept;
  }

 private:
  void clear() {
    for (auto& kept : forward_) kept.reset();
    for (auto& kept : adjoint_) kept.reset();
  }
  void compare(const Array<T, 1>& parameters) {
    if (!is_watched_) return;
    const bool is_same = prepared_from_.size() == parameters.size() &&
                         (parameters.size() == 0 || std::memcmp(prepared_from_.data(), parameters.data(),
                                                                parameters.size() * sizeof(T)) == 0);
    if (is_same) return;
    clear();
    prepared_from_ = parameters;
  }

  std::mutex mutex_;
  bool is_watched_ = false;
  Array<T, 1> prepared_from_;
  std::shared_ptr<const ForwardWeights<T>> forward_[2];
  std::shared_ptr<const AdjointWeights<T>> adjoint_[2];
};

}  // namespace tapestry::detect::detail

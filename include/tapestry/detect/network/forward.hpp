#pragma once
#include <algorithm>
#include <cstddef>
#include <cstring>
#include <tapestry/core/parallel.hpp>
#include <tapestry/detect/network/channels.hpp>
#include <tapestry/detect/network/graph.hpp>
#include <tapestry/detect/network/kept_values.hpp>
#include <tapestry/detect/network/pass.hpp>
#include <tapestry/detect/network/pass_extents.hpp>
#include <tapestry/detect/network/prepared_weights.hpp>
#include <tapestry/detect/network/window_plan.hpp>
#include <tapestry/nn/batch_norm.hpp>
#include <tapestry/nn/engine.hpp>
#include <tapestry/nn/layout.hpp>
#include <tapestry/nn/pointwise.hpp>
#include <tapestry/nn/pooling.hpp>
#include <tapestry/nn/reduction.hpp>
#include <tapestry/nn/upsample.hpp>
#include <vector>

namespace tapestry::detect::detail {

/// One forward pass, layer by layer.
template <class T>
class ForwardPass {
 public:
  /// \param kept   of the one image, to fill; or to use where it holds, so that only windows are computed
  ForwardPass(const Graph& graph, nn::Engine engine, const Array<T, 1>& parameters,
              const ForwardWeights<T>& weights, Pass<T>& pass, KeptValues<T>* kept = nullptr,
              bool holds = false)
      : graph_(graph),
        engine_(engine),
        parameters_(parameters),
        weights_(weights),
        pass_(pass),
        own_(graph, pass.images, holds ? kept->plan.get() : nullptr),
        kept_(kept),
        holds_(holds) {}

  /// \param logits  of each head, [N, C, H, W], to write
  void run(const T* images, const std::vector<T*>& logits) {
    const FeatureShape& image = graph_.shapes.back();
    recycle();
    T* const input = make_output(graph_.image());
    std::copy_n(images, pass_.images * image.size(), input);
    std::size_t head = 0;
    for (std::size_t i = 0; i < graph_.config.layers.size(); ++i) {
      if (graph_.makes_value(i)) {
        run_layer(i);
        save(i);
      }
      if (graph_.hands_out(i)) {
        write_logits(graph_.head_values[head], logits[head]);
        ++head;
      }
      for (const std::size_t value : graph_.inputs[i]) release_if_done(value, i);
      if (graph_.makes_value(i) && graph_.last_use[i] == 0) release_if_done(i, 0);
    }
  }

 private:
  void recycle() {
    for (auto& state : pass_.layers) {
      pass_.workspace.give(std::move(state.output));
      pass_.workspace.give(std::move(state.unnormalised));
      pass_.workspace.give(std::move(state.argument));
    }
    pass_.layers.resize(graph_.image() + 1);
  }

  [[nodiscard]] const T* output_of(std::size_t value) const { return pass_.layers[value].output.data(); }
  [[nodiscard]] T* take_output(std::size_t value) {
    pass_.layers[value].output = pass_.workspace.take(own_.size_of(value));
    return pass_.layers[value].output.data();
  }
  [[nodiscard]] T* make_output(std::size_t value) {
    T* const output = take_output(value);
    restore(value);
    return output;
  }

  void restore(std::size_t value) {
    if (holds_) kept_->restore(graph_.shapes[value], value, pass_.layers[value].output.data());
  }
  void save(std::size_t value) {
    if (kept_ != nullptr && !holds_ && !pass_.layers[value].output.empty())
      kept_->save(graph_.shapes[value], value, output_of(value));
  }

  /// True if the adjoint will ask for a value's output: for an activation's slope, softmax, a product, or
  /// weights; or if somebody else will.
  [[nodiscard]] bool keeps_output(std::size_t value) const {
    if (pass_.mode == Mode::inference) return false;
    if (pass_.mode == Mode::training) return true;
    if (graph_.is_multiplied[value] || graph_.is_told(value)) return true;
    if (value == graph_.image()) return false;
    const LayerConfig& layer = graph_.config.layers[value];
    return layer.kind == LayerKind::softmax || layer.activation == nn::Activation::logistic;
  }

  void release_if_done(std::size_t value, std::size_t layer) {
    if (graph_.last_use[value] != layer || keeps_output(value)) return;
    pass_.workspace.give(std::move(pass_.layers[value].output));
  }

  void run_layer(std::size_t i) {
    const LayerConfig& layer = graph_.config.layers[i];
    if (layer.kind == LayerKind::shortcut) return add_up(i);
    const FeatureShape& in = graph_.shapes[graph_.inputs[i].front()];
    const T* from = output_of(graph_.inputs[i].front());
    if (layer.kind == LayerKind::convolutional) return convolve(i, from);
    T* const to = make_output(i);
    switch (layer.kind) {
      case LayerKind::maxpool: {
        const auto choice_count = pass_.mode == Mode::inference ? 0 : own_.size_of(i);
        pass_.layers[i].choice.resize(choice_count);
        nn::max_pool(graph_.pooling(i), pass_.images, from, to,
                     choice_count > 0 ? pass_.layers[i].choice.data() : nullptr, own_.window_of(i));
        break;
      }
      case LayerKind::upsample: {
        auto window = own_.window_of(i);
        if (window) window = nn::blocks_of_pixels(*window, layer.stride, layer.stride);
        nn::upsample(pass_.images, in.height, in.width, in.channels, layer.stride,
                     static_cast<T>(layer.scale), from, to, window);
        break;
      }
      case LayerKind::route:
        join(i, to);
        break;
      case LayerKind::avgpool:
        nn::average_pool(pass_.images, in.height * in.width, in.channels, from, to);
        break;
      case LayerKind::softmax:
        nn::softmax(pass_.images, in.height * in.width, in.channels, layer.groups, layer.temperature, from,
                    to);
        break;
      case LayerKind::scale_channels:
      case LayerKind::sam:
        multiply(i, from, to);
        break;
      case LayerKind::reorg:
      case LayerKind::reorg3d:
        nn::reorg(graph_.reorganisation(i), pass_.images, from, to);
        break;
      case LayerKind::convolutional:
      case LayerKind::shortcut:
      case LayerKind::yolo:
      case LayerKind::region:
      case LayerKind::dropout:
        break;  // made above, or makes no value
    }
  }

  void multiply(std::size_t i, const T* factors, T* to) {
    const FeatureShape& shape = graph_.shapes[i];
    nn::scale(graph_.factors(i), pass_.images, shape.height * shape.width, shape.channels,
              output_of(graph_.inputs[i].back()), factors, to);
    activate(i, to);
  }

  /// A shortcut, unless a convolution has made it; in place of its first input where nobody else reads that.
  void add_up(std::size_t i) {
    if (!pass_.layers[i].output.empty()) return;
    const auto& inputs = graph_.inputs[i];
    const std::size_t first = inputs.front();
    const bool is_free = graph_.last_use[first] == i && !keeps_output(first) && first != graph_.image();
    if (is_free && std::ranges::count(inputs, first) == 1) {
      pass_.layers[i].output = std::move(pass_.layers[first].output);
      restore(i);
    } else {
      T* const to = make_output(i);
      own_.for_each_values(i, [&](std::size_t place, std::size_t count) {
        nn::copy(output_of(first) + place, to + place, count);
      });
    }
    T* const to = pass_.layers[i].output.data();
    for (std::size_t k = 1; k < inputs.size(); ++k) {
      const std::size_t other = inputs[k];
      if (graph_.is_whole(i, other)) {
        own_.for_each_values(i, [&](std::size_t place, std::size_t count) {
          nn::add(output_of(other) + place, to + place, count);
        });
      } else {
        add_shared(pass_.images, graph_.shapes[other], output_of(other), graph_.shapes[i], to);
      }
    }
    activate(i, to);
  }

  /// The shortcut that convolution i can make in its own place, since nobody else reads its output; else i.
  [[nodiscard]] std::size_t shortcut_of(std::size_t i) const {
    const std::size_t sum = graph_.last_use[i];
    if (pass_.mode == Mode::training || keeps_output(i) || graph_.first_use[i] != sum) return i;
    const LayerConfig& layer = graph_.config.layers[sum];
    const bool is_plain = layer.kind == LayerKind::shortcut && layer.activation == nn::Activation::linear &&
                          graph_.inputs[sum].size() == 2;
    if (!is_plain || !nn::is_piecewise_linear(graph_.config.layers[i].activation)) return i;
    const std::size_t other = addend_of(i, sum);
    if (!graph_.is_whole(sum, other) || !graph_.is_whole(sum, i)) return i;
    return other < i || other == graph_.image() ? sum : i;
  }
  [[nodiscard]] std::size_t addend_of(std::size_t i, std::size_t sum) const {
    return graph_.inputs[sum][graph_.inputs[sum].front() == i ? 1 : 0];
  }

  void convolve(std::size_t i, const T* from) {
    const LayerConfig& layer = graph_.config.layers[i];
    const bool is_leaky = nn::is_piecewise_linear(layer.activation);
    const T slope = is_leaky ? nn::negative_slope<T>(layer.activation) : T(1);
    if (pass_.mode == Mode::training && layer.batch_normalize) {
      convolve_and_normalize(i, from, slope);
    } else {
      nn::Epilogue<T> end{weights_.biases[i].data(), false, slope};
      const bool fuses = keeps_signs(i) && nn::fuses_bits<T>(graph_.convolution(i));
      const std::size_t made = keeps_signs(i) && !fuses ? i : shortcut_of(i);
      if (fuses) end.positive = make_signs(i);
      if (made != i) end.addend = output_of(addend_of(i, made));
      nn::convolve<T>(engine_, weights_.convolutions[i], pass_.images, from, end, take_output(made),
                      graph_.shapes[i].size(), own_.window_of(made));
      restore(made);  // over sums that share a tile with the window: no activation follows there
      if (fuses || made != i) return;
    }
    if (is_leaky) return keep_signs(i, output_of(i));
    activate(i, pass_.layers[i].output.data());
  }

  void convolve_and_normalize(std::size_t i, const T* from, T slope) {
    const LayerConfig& layer = graph_.config.layers[i];
    auto& state = pass_.layers[i];
    const ConvolutionParameters& own = graph_.layout.layers[i];
    state.unnormalised = pass_.workspace.take(own_.size_of(i));
    nn::convolve<T>(engine_, weights_.convolutions[i], pass_.images, from, {}, state.unnormalised.data(),
                    graph_.shapes[i].size());
    state.statistics = nn::batch_statistics(state.unnormalised.data(), own_.pixels_of(i), layer.filters,
                                            graph_.config.batch_norm_epsilon);
    nn::batch_norm(state.statistics, parameters_.data() + own.scale, parameters_.data() + own.bias,
                   state.unnormalised.data(), own_.pixels_of(i), slope, make_output(i));
  }

  [[nodiscard]] bool keeps_signs(std::size_t i) const {
    return pass_.mode != Mode::inference && nn::slope_needs_sign(graph_.config.layers[i].activation);
  }
  [[nodiscard]] std::uint8_t* make_signs(std::size_t i) {
    pass_.layers[i].positive.resize(block_count(own_.size_of(i), 8));
    return pass_.layers[i].positive.data();
  }

  /// For the adjoint of leaky and relu.
  void keep_signs(std::size_t i, const T* values) {
    if (!keeps_signs(i)) return;
    std::uint8_t* const signs = make_signs(i);
    own_.for_each_values(i, [&](std::size_t place, std::size_t count) {
      nn::positive_bits(values + place, signs + place / 8, count);
    });
  }

  void activate(std::size_t i, T* values) {
    const nn::Activation activation = graph_.config.layers[i].activation;
    const bool keeps_argument = pass_.mode != Mode::inference && nn::slope_needs_argument(activation);
    nn::Buffer<T>& argument = pass_.layers[i].argument;
    if (keeps_argument) argument = pass_.workspace.take(own_.size_of(i));
    own_.for_each_values(i, [&](std::size_t place, std::size_t count) {
      if (keeps_argument) std::memcpy(argument.data() + place, values + place, count * sizeof(T));
      nn::activate(activation, values + place, count);
    });
    keep_signs(i, values);
  }

  void join(std::size_t i, T* to) {
    const LayerConfig& layer = graph_.config.layers[i];
    for (const std::size_t value : graph_.inputs[i]) {
      const std::size_t channels = graph_.shapes[value].channels;
      const std::size_t count = channels / layer.groups;
      const std::size_t pitch = graph_.shapes[i].channels;
      const T* const from = output_of(value) + layer.group * count;
      own_.for_each_pixels(i, [&](std::size_t first, std::size_t pixels) {
        copy_channels(from + first * channels, channels, to + first * pitch, pitch, count, pixels, false);
      });
      to += count;
    }
  }

  void write_logits(std::size_t value, T* logits) {
    const FeatureShape& shape = graph_.shapes[value];
    nn::channels_first(pass_.images, shape.channels, shape.height * shape.width, output_of(value), logits);
  }

  const Graph& graph_;
  nn::Engine engine_;
  const Array<T, 1>& parameters_;
  const ForwardWeights<T>& weights_;
  Pass<T>& pass_;
  PassExtents own_;
  KeptValues<T>* kept_;
  bool holds_;
};

}  // namespace tapestry::detect::detail

#pragma once
#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <tapestry/detect/network/forward.hpp>
#include <tapestry/nn/convolution_weight_adjoint.hpp>
#include <utility>
#include <vector>

namespace tapestry::detect::detail {

/// One backward pass, from the last layer to the first. Adjoints of values are made by the first reader
/// that reaches them and added to by the others.
template <class T>
class BackwardPass {
 public:
  BackwardPass(const Graph& graph, nn::Engine engine, const Array<T, 1>& parameters,
               const AdjointWeights<T>& weights, Pass<T>& pass)
      : graph_(graph),
        engine_(pass.plan == nullptr ? engine : pass.plan->engine),
        parameters_(parameters),
        weights_(weights),
        pass_(pass),
        own_(graph, pass.images, pass.plan.get()),
        adjoints_(graph.image() + 1),
        is_gated_(graph.image() + 1, false) {}

  /// Adds to images_adjoint, [N, H, W, C], and to parameters_adjoint, each unless null.
  /// \param logits_adjoint  of each head, [N, C, H, W]; null stands for zeros
  void run(const std::vector<const T*>& logits_adjoint, T* images_adjoint, T* parameters_adjoint) {
    wants_image_ = images_adjoint != nullptr;
    parameters_adjoint_ = parameters_adjoint;
    run_down_to(0, logits_adjoint);
    auto& image = adjoints_[graph_.image()];
    if (wants_image_ && !image.empty()) add_to_image(image.data(), images_adjoint);
    pass_.workspace.give(std::move(image));
  }

  /// Adds to images_adjoint what a value that is told asks of the images.
  /// \param adjoint  of the value, [N, H, W, C]
  void run_from(std::size_t value, nn::Buffer<T>&& adjoint, T* images_adjoint) {
    adjoints_[value] = std::move(adjoint);
    run(std::vector<const T*>(graph_.head_values.size(), nullptr), images_adjoint, nullptr);
  }

  /// What all that read a value that is told ask of it: [N, H, W, C], or empty if nobody asks anything.
  [[nodiscard]] nn::Buffer<T> adjoint_of(std::size_t value, const std::vector<const T*>& logits_adjoint) {
    run_down_to(value + 1, logits_adjoint);
    if (graph_.hands_out(value)) read_head(value, logits_adjoint);
    nn::Buffer<T> asked = std::move(adjoints_[value]);
    for (auto& adjoint : adjoints_) pass_.workspace.give(std::move(adjoint));
    return asked;
  }

 private:
  /// In the window that has changed, which may be smaller than what is needed to compute it.
  void add_to_image(const T* adjoint, T* images_adjoint) const {
    const FeatureShape& shape = graph_.shapes.back();
    for_each_run(pass_.images, shape, pass_.window, [&](std::size_t first, std::size_t count) {
      nn::add(adjoint + first * shape.channels, images_adjoint + first * shape.channels,
              count * shape.channels);
    });
  }

  /// Pulls back through the layers from the last to `first`.
  void run_down_to(std::size_t first, const std::vector<const T*>& logits_adjoint) {
    for (std::size_t i = graph_.image(); i-- > first;) {
      if (graph_.hands_out(i)) read_head(i, logits_adjoint);
      if (!graph_.makes_value(i) || adjoints_[i].empty()) continue;
      run_layer(i);
      pass_.workspace.give(std::move(adjoints_[i]));
    }
  }

  /// What is asked of the logits that layer i hands out.
  void read_head(std::size_t i, const std::vector<const T*>& logits_adjoint) {
    std::size_t head = 0;
    for (std::size_t before = 0; before < i; ++before) head += graph_.hands_out(before) ? 1U : 0U;
    if (logits_adjoint[head] != nullptr) read_logits(graph_.head_values[head], logits_adjoint[head]);
  }

  /// The adjoint of a value to add to; zero if nothing has been added before.
  [[nodiscard]] T* summed_adjoint(std::size_t value) {
    if (adjoints_[value].empty()) {
      adjoints_[value] = pass_.workspace.take(own_.size_of(value));
      adjoints_[value].fill_zero();
    }
    return adjoints_[value].data();
  }

  void read_logits(std::size_t value, const T* logits_adjoint) {
    const FeatureShape& shape = graph_.shapes[value];
    auto last = pass_.workspace.take(own_.size_of(value));
    nn::channels_last(pass_.images, shape.channels, shape.height * shape.width, logits_adjoint, last.data());
    add_whole(value, std::move(last));
  }

  /// Adds a buffer that nobody else needs.
  void add_whole(std::size_t value, nn::Buffer<T>&& adjoint) {
    if (adjoints_[value].empty()) {
      adjoints_[value] = std::move(adjoint);
      return;
    }
    add_copy(value, adjoint.data());
    pass_.workspace.give(std::move(adjoint));
  }

  /// Adds a buffer that others need, too.
  void add_copy(std::size_t value, const T* adjoint) {
    const bool is_first = adjoints_[value].empty();
    if (is_first) adjoints_[value] = pass_.workspace.take(own_.size_of(value));
    T* const to = adjoints_[value].data();
    own_.for_each_values(value, [&](std::size_t place, std::size_t count) {
      is_first ? nn::copy(adjoint + place, to + place, count) : nn::add(adjoint + place, to + place, count);
    });
  }

  /// adjoint · slopes of the activation that made a value, of which only signs are kept; both may be the
  /// same.
  void multiply_by_signs(std::size_t value, const T* adjoint, T* to) const {
    const std::uint8_t* const signs = pass_.layers[value].positive.data();
    own_.for_each_values(value, [&](std::size_t place, std::size_t count) {
      nn::leaky_adjoint(signs + place / 8, slope_of(value), adjoint + place, to + place, count);
    });
  }

  /// True if layer i, the last to add to a value's adjoint, may as well multiply it by the slopes of the
  /// activation that made the value.
  [[nodiscard]] bool is_gate(std::size_t i, std::size_t value) const {
    return graph_.first_use[value] == i && value != graph_.image() && !graph_.is_told(value) &&
           !pass_.layers[value].positive.empty() &&
           nn::slope_needs_sign(graph_.config.layers[value].activation);
  }

  /// Gives a shortcut's adjoint to all that it adds. One of them takes the buffer.
  void hand_on(std::size_t i) {
    const T* const adjoint = adjoints_[i].data();
    const auto& inputs = graph_.inputs[i];
    const auto is_gated_copy = [&](std::size_t value) {
      return adjoints_[value].empty() && is_gate(i, value) && graph_.is_whole(i, value) &&
             std::count(inputs.begin(), inputs.end(), value) == 1;  // what comes twice is gated with the sum
    };
    std::size_t taker = 0;
    for (std::size_t k = inputs.size(); k-- > 0;)
      if (!is_gated_copy(inputs[k]) && graph_.is_whole(i, inputs[k])) taker = k;
    for (std::size_t k = 0; k < inputs.size(); ++k) {
      const std::size_t value = inputs[k];
      if (k == taker) continue;
      if (!graph_.is_whole(i, value)) {
        add_shared(pass_.images, graph_.shapes[i], adjoint, graph_.shapes[value], summed_adjoint(value));
        continue;
      }
      if (!is_gated_copy(value)) {
        add_copy(value, adjoint);
        continue;
      }
      adjoints_[value] = pass_.workspace.take(own_.size_of(value));
      multiply_by_signs(value, adjoint, adjoints_[value].data());
      is_gated_[value] = true;
    }
    add_whole(inputs[taker], std::move(adjoints_[i]));
  }

  [[nodiscard]] T slope_of(std::size_t value) const {
    return nn::negative_slope<T>(graph_.config.layers[value].activation);
  }

  void run_layer(std::size_t i) {
    const LayerConfig& layer = graph_.config.layers[i];
    const std::size_t input = graph_.inputs[i].front();
    const FeatureShape& in = graph_.shapes[input];
    T* const adjoint = adjoints_[i].data();
    switch (layer.kind) {
      case LayerKind::convolutional:
        convolve_adjoint(i, input, adjoint);
        break;
      case LayerKind::maxpool:
        nn::max_pool_adjoint(graph_.pooling(i), pass_.images, pass_.layers[i].choice.data(), adjoint,
                             summed_adjoint(input), own_.window_of(i));
        break;
      case LayerKind::upsample:
        nn::upsample_adjoint(pass_.images, in.height, in.width, in.channels, layer.stride,
                             static_cast<T>(layer.scale), adjoint, summed_adjoint(input),
                             own_.window_of(input));
        break;
      case LayerKind::route:
        join_adjoint(i, adjoint);
        break;
      case LayerKind::shortcut:
        activation_adjoint(i, adjoint);
        hand_on(i);
        break;
      case LayerKind::avgpool:
        nn::average_pool_adjoint(pass_.images, in.height * in.width, in.channels, adjoint,
                                 summed_adjoint(input));
        break;
      case LayerKind::softmax:
        nn::softmax_adjoint(pass_.images, in.height * in.width, in.channels, layer.groups, layer.temperature,
                            pass_.layers[i].output.data(), adjoint, summed_adjoint(input));
        break;
      case LayerKind::scale_channels:
      case LayerKind::sam:
        multiply_adjoint(i, adjoint);
        break;
      case LayerKind::reorg:
      case LayerKind::reorg3d:
        nn::reorg_adjoint(graph_.reorganisation(i), pass_.images, adjoint, summed_adjoint(input));
        break;
      case LayerKind::yolo:
      case LayerKind::region:
      case LayerKind::dropout:
        break;  // makes no value
    }
  }

  void multiply_adjoint(std::size_t i, T* adjoint) {
    activation_adjoint(i, adjoint);
    const FeatureShape& shape = graph_.shapes[i];
    const std::size_t factors = graph_.inputs[i].front(), value = graph_.inputs[i].back();
    nn::scale_adjoint(graph_.factors(i), pass_.images, shape.height * shape.width, shape.channels,
                      pass_.layers[value].output.data(), pass_.layers[factors].output.data(), adjoint,
                      summed_adjoint(value), summed_adjoint(factors));
  }

  void activation_adjoint(std::size_t i, T* adjoint) {
    const nn::Activation activation = graph_.config.layers[i].activation;
    const auto& state = pass_.layers[i];
    if (activation == nn::Activation::linear || is_gated_[i]) return;
    if (nn::slope_needs_sign(activation)) return multiply_by_signs(i, adjoint, adjoint);
    const T* kept = nn::slope_needs_argument(activation) ? state.argument.data() : state.output.data();
    own_.for_each_values(i, [&](std::size_t place, std::size_t count) {
      nn::activation_adjoint(activation, kept + place, adjoint + place, count);
    });
  }

  void convolve_adjoint(std::size_t i, std::size_t input, T* adjoint) {
    const LayerConfig& layer = graph_.config.layers[i];
    activation_adjoint(i, adjoint);
    T* const own_adjoint = parameters_adjoint_;
    const ConvolutionParameters& own = graph_.layout.layers[i];
    if (pass_.mode == Mode::training && layer.batch_normalize) {
      const auto& state = pass_.layers[i];
      nn::batch_norm_adjoint(state.statistics, parameters_.data() + own.scale, state.unnormalised.data(),
                             own_.pixels_of(i), adjoint,
                             own_adjoint != nullptr ? own_adjoint + own.scale : nullptr,
                             own_adjoint != nullptr ? own_adjoint + own.bias : nullptr);
    } else if (own_adjoint != nullptr) {
      nn::bias_adjoint(adjoint, own_.pixels_of(i), layer.filters, own_adjoint + own.bias);
    }
    const nn::ConvolutionShape shape = graph_.convolution(i);
    if (own_adjoint != nullptr) {
      nn::convolution_weight_adjoint(shape, pass_.images, pass_.layers[input].output.data(), adjoint,
                                     pass_.partial_sums, own_adjoint + own.weight);
    }
    if (input == graph_.image() && !wants_image_) return;
    const bool covers = nn::adjoint_covers_input(shape);
    nn::Epilogue<T> end{nullptr, !covers || !adjoints_[input].empty(), T(1)};
    if (!end.adds) adjoints_[input] = pass_.workspace.take(own_.size_of(input));
    T* const in_adjoint = summed_adjoint(input);
    const auto& parts = weights_.convolutions[i];
    if (covers && is_gate(i, input) && nn::fuses_bits<T>(parts.front().shape)) {
      end.gate = pass_.layers[input].positive.data();
      end.slope = slope_of(input);
      is_gated_[input] = true;
    }
    for (const auto& part : parts)
      nn::convolve<T>(engine_, part, pass_.images, adjoint, end, in_adjoint, shape.in_size(),
                      own_.window_of(input));
  }

  void join_adjoint(std::size_t i, const T* adjoint) {
    const LayerConfig& layer = graph_.config.layers[i];
    for (const std::size_t value : graph_.inputs[i]) {
      const std::size_t channels = graph_.shapes[value].channels;
      const std::size_t count = channels / layer.groups;
      const std::size_t pitch = graph_.shapes[i].channels;
      T* const to = summed_adjoint(value) + layer.group * count;
      own_.for_each_pixels(value, [&](std::size_t first, std::size_t pixels) {
        copy_channels(adjoint + first * pitch, pitch, to + first * channels, channels, count, pixels, true);
      });
      adjoint += count;
    }
  }

  const Graph& graph_;
  nn::Engine engine_;
  const Array<T, 1>& parameters_;
  const AdjointWeights<T>& weights_;
  Pass<T>& pass_;
  PassExtents own_;
  std::vector<nn::Buffer<T>> adjoints_;
  std::vector<bool> is_gated_;  ///< the activation's slopes are in the adjoint already
  bool wants_image_ = false;
  T* parameters_adjoint_ = nullptr;
};

}  // namespace tapestry::detect::detail

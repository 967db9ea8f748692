#pragma once
#include "../decisions.hpp"
#include "folded_convolution.hpp"
#include "onednn_convolution.hpp"

namespace tapestry::benchmarks {
/// The detector's forward pass as a chain of oneDNN's primitives: batch normalisation folded, leaky a part of
/// the direct convolutions, memory shared by values that do not live at the same time. For a gradient it
/// keeps the outputs of activations and what the pools note, nothing else.
class OneDnnForward {
 public:
  OneDnnForward(const Problem& problem, const std::string& weights_path, bool keeps_for_gradient,
                bool tries_winograd)
      : problem_(problem),
        wants_gradient_(keeps_for_gradient),
        parameters_(problem, weights_path),
        choice_(engine_, tries_winograd),
        pool_(engine_),
        forward_(engine_),
        values_(layer_count()),
        notes_(layer_count()),
        last_reader_(layer_count()) {
    choose_algorithms();
    for (std::size_t i = 0; i < layer_count(); ++i)
      for (const std::size_t input : inputs(i)) last_reader_[input] = i;
    for (std::size_t i = 0; i < layer_count(); ++i) {
      plan_forward(i);
      forget_values(i);
    }
  }

  void run() { forward_.run(); }

  [[nodiscard]] std::vector<float> logits() const {
    std::vector<float> all;
    for (const std::size_t head : problem_.heads) {
      const auto values = plain(values_[producer(head)].memory, head, dnnl::memory::format_tag::nchw);
      all.insert(all.end(), values.begin(), values.end());
    }
    return all;
  }

  [[nodiscard]] Decisions decisions() const {
    constexpr auto layout = dnnl::memory::format_tag::nhwc;
    Decisions decisions = no_decisions(problem_);
    for (std::size_t i = 0; i < layer_count(); ++i) {
      if (has_kink(layer(i))) {
        const auto values = plain(values_[i].memory, i, layout);
        decisions.is_positive[i] = signs(values.data(), values.size());
      }
      if (layer(i).kind == Kind::maxpool)
        decisions.chosen[i] =
            pool_choices(problem_, i, plain(values_[producer(i - 1)].memory, i - 1, layout));
    }
    return decisions;
  }

 protected:
  using Kind = detect::LayerKind;

  [[nodiscard]] std::size_t layer_count() const { return problem_.config.layers.size(); }
  [[nodiscard]] const detect::LayerConfig& layer(std::size_t i) const { return problem_.config.layers[i]; }
  [[nodiscard]] const detect::FeatureShape& shape(std::size_t i) const { return problem_.shapes[i]; }

  /// The layer whose output a layer's output is: its own, unless it only passes one on.
  [[nodiscard]] std::size_t producer(std::size_t i) const {
    while (layer(i).kind == Kind::yolo || layer(i).kind == Kind::dropout ||
           (layer(i).kind == Kind::route && layer(i).sources.size() == 1 && layer(i).groups == 1))
      i = detect::inputs_of(problem_.config, i).front();
    return i;
  }

  /// The producers of what a layer reads; none for the first.
  [[nodiscard]] std::vector<std::size_t> inputs(std::size_t i) const {
    auto inputs = detect::inputs_of(problem_.config, i);
    for (std::size_t& input : inputs) input = producer(input);
    return inputs;
  }

  [[nodiscard]] ConvolutionTask task(std::size_t i) const {
    const detect::FeatureShape picture{problem_.config.channels, problem_.picture.shape(2),
                                       problem_.picture.shape(3)};
    return {i == 0 ? picture : shape(i - 1), shape(i), layer(i), slope_of(problem_, i)};
  }

  [[nodiscard]] dnnl::memory reordered_weights(const ConvolutionTask& task, FoldedConvolution& folded,
                                               const dnnl::memory::desc& wanted) const {
    const dnnl::memory plain(task.plain_weights(), engine_, folded.weights.data());
    dnnl::memory weights(wanted, engine_);
    Plan once(engine_);
    once.append_reorder(plain, weights);
    once.run();
    return weights;
  }

  /// Rows and columns that a pool's windows reach beyond its input's end.
  [[nodiscard]] dnnl::memory::dims pool_overhang(std::size_t i) const {
    const auto overhang = [&](std::size_t cells, std::size_t extent) {
      const std::size_t end = (cells - 1) * layer(i).stride + layer(i).size;
      return dim(std::max(end, extent + layer(i).padding / 2) - extent - layer(i).padding / 2);
    };
    const detect::FeatureShape& in = shape(inputs(i).front());
    return {overhang(shape(i).height, in.height), overhang(shape(i).width, in.width)};
  }

  [[nodiscard]] dnnl::pooling_forward::primitive_desc pooling(std::size_t i) const {
    return {{wants_gradient_ ? dnnl::prop_kind::forward_training : dnnl::prop_kind::forward_inference,
             dnnl::algorithm::pooling_max, blocked(shape(inputs(i).front())), blocked(shape(i)),
             both(layer(i).stride), both(layer(i).size), both(layer(i).padding / 2), pool_overhang(i)},
            engine_};
  }

  [[nodiscard]] dnnl::resampling_forward::primitive_desc upsampling(std::size_t i) const {
    return {{dnnl::prop_kind::forward_inference, dnnl::algorithm::resampling_nearest,
             blocked(shape(inputs(i).front())), blocked(shape(i))},
            engine_};
  }

  void append_sum(Plan& plan, const dnnl::memory& a, const dnnl::memory& b, const dnnl::memory& sum) const {
    const dnnl::binary::desc add(dnnl::algorithm::binary_add, a.get_desc(), b.get_desc(), sum.get_desc());
    plan.append(dnnl::binary({add, engine_}),
                {{DNNL_ARG_SRC_0, a}, {DNNL_ARG_SRC_1, b}, {DNNL_ARG_DST, sum}});
  }

  const Problem& problem_;
  bool wants_gradient_;
  FoldedConvolutions parameters_;
  dnnl::engine engine_{dnnl::engine::kind::cpu, 0};
  AlgorithmChoice choice_;
  Pool pool_;
  Plan forward_;
  std::vector<Value> values_;
  std::vector<dnnl::memory> notes_;  ///< which value each pool took

 private:
  /// Before anything else takes memory, so that trying costs none of its own.
  void choose_algorithms() {
    for (std::size_t i = 0; i < layer_count(); ++i) {
      if (layer(i).kind != Kind::convolutional) continue;
      (void)choice_.forward(task(i));
      if (wants_gradient_) (void)choice_.backward(task(i));
    }
  }

  void plan_forward(std::size_t i) {
    if (producer(i) != i) return;
    switch (layer(i).kind) {
      case Kind::convolutional:
        convolve(i);
        break;
      case Kind::maxpool:
        max_pool(i);
        break;
      case Kind::upsample: {
        const Value& in = values_[inputs(i).front()];
        values_[i] = pool_.take(blocked(shape(i)));
        forward_.append(dnnl::resampling_forward(upsampling(i)),
                        {{DNNL_ARG_SRC, in.memory}, {DNNL_ARG_DST, values_[i].memory}});
        break;
      }
      case Kind::route:
        join(i);
        break;
      case Kind::shortcut:
        add_shortcut(i);
        break;
      default:
        throw not_supported(problem_, i);
    }
  }

  /// Frees values that no later layer reads, unless the gradient needs them.
  void forget_values(std::size_t i) {
    for (std::size_t earlier = 0; earlier <= i; ++earlier) {
      const std::size_t reader = last_reader_[earlier];
      if (values_[earlier].is_empty() || reader > i || is_kept(earlier)) continue;
      values_[earlier] = Value();
    }
  }

  [[nodiscard]] bool is_kept(std::size_t i) const {
    for (const std::size_t head : problem_.heads)
      if (producer(head) == i) return true;
    if (!wants_gradient_) return false;
    for (std::size_t j = 1; j < layer_count(); ++j)
      if (layer(j).kind == Kind::maxpool && producer(j - 1) == i) return true;
    return has_kink(layer(i));
  }

  void convolve(std::size_t i) {
    const ConvolutionTask task = this->task(i);
    const auto algorithm = choice_.forward(task);
    const auto description = forward_convolution(task, algorithm, engine_);
    FoldedConvolution folded = parameters_.read(i);
    dnnl::memory biases(description.bias_desc(), engine_);
    std::memcpy(biases.get_data_handle(), folded.biases.data(), 4 * folded.biases.size());
    const Value in = input_in_layout(i, description.src_desc());
    values_[i] = pool_.take(blocked(shape(i)));
    forward_.append(dnnl::convolution_forward(description),
                    {{DNNL_ARG_SRC, in.memory},
                     {DNNL_ARG_WEIGHTS, reordered_weights(task, folded, description.weights_desc())},
                     {DNNL_ARG_BIAS, biases},
                     {DNNL_ARG_DST, values_[i].memory}});
    if (algorithm == dnnl::algorithm::convolution_winograd && task.slope != 1)
      choice_.append_activation(forward_, values_[i].memory, task.slope);
  }

  /// Input of a convolution, in the layout that it needs.
  [[nodiscard]] Value input_in_layout(std::size_t i, const dnnl::memory::desc& wanted) {
    const dnnl::memory given = i == 0 ? dnnl::memory(description(task(0).in, dnnl::memory::format_tag::nchw),
                                                     engine_, const_cast<float*>(problem_.picture.data()))
                                      : values_[inputs(i).front()].memory;
    if (given.get_desc() == wanted) return {given};
    const Value changed = pool_.take(wanted);
    forward_.append_reorder(given, changed.memory);
    return changed;
  }

  void max_pool(std::size_t i) {
    const auto description = pooling(i);
    values_[i] = pool_.take(blocked(shape(i)));
    std::unordered_map<int, dnnl::memory> arguments{{DNNL_ARG_SRC, values_[inputs(i).front()].memory},
                                                    {DNNL_ARG_DST, values_[i].memory}};
    if (wants_gradient_) {
      notes_[i] = dnnl::memory(description.workspace_desc(), engine_);
      arguments.insert({DNNL_ARG_WORKSPACE, notes_[i]});
    }
    forward_.append(dnnl::pooling_forward(description), std::move(arguments));
  }

  void join(std::size_t i) {
    if (layer(i).groups != 1) throw not_supported(problem_, i);
    std::vector<dnnl::memory::desc> parts;
    std::unordered_map<int, dnnl::memory> arguments;
    for (const std::size_t input : inputs(i)) {
      arguments.insert({DNNL_ARG_MULTIPLE_SRC + static_cast<int>(parts.size()), values_[input].memory});
      parts.push_back(blocked(shape(input)));
    }
    values_[i] = pool_.take(blocked(shape(i)));
    arguments.insert({DNNL_ARG_DST, values_[i].memory});
    forward_.append(dnnl::concat({blocked(shape(i)), 1, parts, engine_}), std::move(arguments));
  }

  void add_shortcut(std::size_t i) {
    const auto in = inputs(i);
    if (in.size() != 2) throw not_supported(problem_, i);
    const bool overwrites = last_reader_[in[0]] == i && !is_kept(in[0]);
    values_[i] = overwrites ? values_[in[0]] : pool_.take(blocked(shape(i)));
    append_sum(forward_, values_[in[0]].memory, values_[in[1]].memory, values_[i].memory);
    if (const float slope = slope_of(problem_, i); slope != 1)
      choice_.append_activation(forward_, values_[i].memory, slope);
  }

  [[nodiscard]] std::vector<float> plain(const dnnl::memory& value, std::size_t i,
                                         dnnl::memory::format_tag layout) const {
    std::vector<float> values(shape(i).size());
    Plan once(engine_);
    once.append_reorder(value, {description(shape(i), layout), engine_, values.data()});
    once.run();
    return values;
  }

  std::vector<std::size_t> last_reader_;
};
}  // namespace tapestry::benchmarks

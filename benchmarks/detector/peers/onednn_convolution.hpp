#pragma once
#include "../problem.hpp"
#include "onednn_plan.hpp"

namespace tapestry::benchmarks {
[[nodiscard]] inline dnnl::memory::dim dim(std::size_t count) {
  return static_cast<dnnl::memory::dim>(count);
}

/// Of rows and of columns.
[[nodiscard]] inline dnnl::memory::dims both(std::size_t extent) { return {dim(extent), dim(extent)}; }

[[nodiscard]] inline dnnl::memory::desc description(const detect::FeatureShape& shape,
                                                    dnnl::memory::format_tag layout) {
  return {
      {1, dim(shape.channels), dim(shape.height), dim(shape.width)}, dnnl::memory::data_type::f32, layout};
}

/// Channels in a block of oneDNN's own layout. With blocks of 16 it has no fast kernel where AVX-512 is
/// missing.
[[nodiscard]] inline std::size_t block_channels() {
  static const std::size_t channels = dnnl::get_effective_cpu_isa() >= dnnl::cpu_isa::avx512_core ? 16 : 8;
  return channels;
}

[[nodiscard]] inline dnnl::memory::desc blocked(const detect::FeatureShape& shape) {
  using Tag = dnnl::memory::format_tag;
  return description(shape, block_channels() == 16 ? Tag::nChw16c : Tag::nChw8c);
}

/// A convolution layer as oneDNN sees it.
struct ConvolutionTask {
  detect::FeatureShape in;
  detect::FeatureShape out;
  detect::LayerConfig layer;
  float slope;  ///< of the activation below 0

  [[nodiscard]] dnnl::memory::dims weight_dims() const {
    const dnnl::memory::dim size = dim(layer.size);
    if (layer.groups == 1) return {dim(out.channels), dim(in.channels), size, size};
    return {dim(layer.groups), dim(out.channels / layer.groups), dim(in.channels / layer.groups), size, size};
  }
  [[nodiscard]] dnnl::memory::desc weights(dnnl::memory::format_tag layout) const {
    return {weight_dims(), dnnl::memory::data_type::f32, layout};
  }
  [[nodiscard]] dnnl::memory::desc plain_weights() const {
    return weights(layer.groups == 1 ? dnnl::memory::format_tag::oihw : dnnl::memory::format_tag::goihw);
  }
  /// The picture's three channels are not blocked; the library chooses.
  [[nodiscard]] dnnl::memory::desc source() const {
    return in.channels < block_channels() ? description(in, dnnl::memory::format_tag::any) : blocked(in);
  }
  [[nodiscard]] std::string key() const {
    std::string text;
    for (const std::size_t part : {in.channels, in.height, in.width, out.channels, layer.size, layer.stride,
                                   layer.padding, layer.dilation, layer.groups})
      text += std::to_string(part) + " ";
    return text + std::to_string(slope);
  }
};

/// Direct convolution takes the activation in; Winograd's refuses a slope below 0, so that a pass of its own
/// must follow, and works for inference only under the name of training.
[[nodiscard]] inline dnnl::convolution_forward::primitive_desc forward_convolution(
    const ConvolutionTask& task, dnnl::algorithm algorithm, const dnnl::engine& engine) {
  const bool is_winograd = algorithm == dnnl::algorithm::convolution_winograd;
  const auto& layer = task.layer;
  dnnl::primitive_attr attributes;
  if (task.slope != 1 && !is_winograd) {
    dnnl::post_ops after;
    after.append_eltwise(1, dnnl::algorithm::eltwise_relu, task.slope, 0);
    attributes.set_post_ops(after);
  }
  const dnnl::memory::desc biases({dim(task.out.channels)}, dnnl::memory::data_type::f32,
                                  dnnl::memory::format_tag::a);
  return {{is_winograd ? dnnl::prop_kind::forward_training : dnnl::prop_kind::forward_inference, algorithm,
           task.source(), task.weights(dnnl::memory::format_tag::any), biases, blocked(task.out),
           both(layer.stride), both(layer.dilation - 1), both(layer.padding), both(layer.padding)},
          attributes,
          engine};
}

[[nodiscard]] inline dnnl::convolution_backward_data::primitive_desc backward_convolution(
    const ConvolutionTask& task, dnnl::algorithm algorithm, const dnnl::engine& engine) {
  const auto& layer = task.layer;
  const auto hint = forward_convolution(task, dnnl::algorithm::convolution_direct, engine);
  return {{algorithm, task.source(), task.weights(dnnl::memory::format_tag::any), blocked(task.out),
           both(layer.stride), both(layer.dilation - 1), both(layer.padding), both(layer.padding)},
          engine,
          hint};
}

/// Finds the faster algorithm for each shape of convolution by trying both.
class AlgorithmChoice {
 public:
  /// \param tries_winograd  otherwise the answer is always direct
  AlgorithmChoice(const dnnl::engine& engine, bool tries_winograd)
      : engine_(engine), tries_winograd_(tries_winograd) {}

  [[nodiscard]] dnnl::algorithm forward(const ConvolutionTask& task) {
    return choose("forward " + task.key(), task, [&](dnnl::algorithm algorithm) {
      const auto description = forward_convolution(task, algorithm, engine_);
      const dnnl::memory output = zeroed(description.dst_desc());
      Plan plan(engine_);
      plan.append(dnnl::convolution_forward(description),
                  {{DNNL_ARG_SRC, zeroed(description.src_desc())},
                   {DNNL_ARG_WEIGHTS, zeroed(description.weights_desc())},
                   {DNNL_ARG_BIAS, zeroed(description.bias_desc())},
                   {DNNL_ARG_DST, output}});
      if (algorithm == dnnl::algorithm::convolution_winograd && task.slope != 1)
        append_activation(plan, output, task.slope);
      return median_seconds(plan);
    });
  }

  [[nodiscard]] dnnl::algorithm backward(const ConvolutionTask& task) {
    return choose("backward " + task.key(), task, [&](dnnl::algorithm algorithm) {
      const auto description = backward_convolution(task, algorithm, engine_);
      Plan plan(engine_);
      plan.append(dnnl::convolution_backward_data(description),
                  {{DNNL_ARG_DIFF_DST, zeroed(description.diff_dst_desc())},
                   {DNNL_ARG_WEIGHTS, zeroed(description.weights_desc())},
                   {DNNL_ARG_DIFF_SRC, zeroed(description.diff_src_desc())}});
      return median_seconds(plan);
    });
  }

  void append_activation(Plan& plan, const dnnl::memory& values, float slope) const {
    const dnnl::eltwise_forward::desc leaky(dnnl::prop_kind::forward_inference, dnnl::algorithm::eltwise_relu,
                                            values.get_desc(), slope);
    plan.append(dnnl::eltwise_forward({leaky, engine_}), {{DNNL_ARG_SRC, values}, {DNNL_ARG_DST, values}});
  }

 private:
  template <class Seconds>
  [[nodiscard]] dnnl::algorithm choose(const std::string& key, const ConvolutionTask& task, Seconds seconds) {
    constexpr auto direct = dnnl::algorithm::convolution_direct;
    constexpr auto winograd = dnnl::algorithm::convolution_winograd;
    if (!tries_winograd_ || task.layer.size != 3) return direct;
    const auto known = chosen_.find(key);
    if (known != chosen_.end()) return known->second;
    auto choice = direct;
    try {
      if (seconds(winograd) < seconds(direct)) choice = winograd;
    } catch (const dnnl::error&) {  // Winograd does not know the shape
    }
    chosen_[key] = choice;
    return choice;
  }

  [[nodiscard]] dnnl::memory zeroed(const dnnl::memory::desc& description) const {
    const dnnl::memory memory(description, engine_);
    std::memset(memory.get_data_handle(), 0, description.get_size());
    return memory;
  }

  [[nodiscard]] static double median_seconds(Plan& plan) {
    using Clock = std::chrono::steady_clock;
    std::vector<double> times(5);
    plan.run();
    for (double& time : times) {
      const auto start = Clock::now();
      plan.run();
      time = std::chrono::duration<double>(Clock::now() - start).count();
    }
    std::nth_element(times.begin(), times.begin() + 2, times.end());
    return times[2];
  }

  dnnl::engine engine_;
  bool tries_winograd_;
  std::map<std::string, dnnl::algorithm> chosen_;
};
}  // namespace tapestry::benchmarks

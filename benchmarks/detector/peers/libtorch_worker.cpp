// The detector in libtorch: batch normalisation folded, activations channels-last, gradient by its autograd.
#include <torch/torch.h>

#include "../worker_program.hpp"
#include "folded_convolution.hpp"

namespace tapestry::benchmarks {
namespace {
constexpr auto channels_last = at::MemoryFormat::ChannelsLast;

[[nodiscard]] std::int64_t signed_count(std::size_t count) { return static_cast<std::int64_t>(count); }

/// A copy of our array as a tensor.
[[nodiscard]] at::Tensor tensor_of(const Array<float, 4>& array) {
  std::vector<std::int64_t> shape(array.shape().begin(), array.shape().end());
  return torch::from_blob(const_cast<float*>(array.data()), shape).clone(channels_last);
}

[[nodiscard]] std::vector<float> values_of(const at::Tensor& tensor, at::IntArrayRef order) {
  const at::Tensor ordered = tensor.detach().permute(order).contiguous();
  return {ordered.data_ptr<float>(), ordered.data_ptr<float>() + ordered.numel()};
}

class LibtorchDetector {
 public:
  LibtorchDetector(const Problem& problem, const WorkerOptions& options)
      : problem_(problem),
        wants_gradient_(options.wants_gradient),
        parameters_(problem.config.layers.size()),
        outputs_(problem.config.layers.size()),
        last_reader_(problem.config.layers.size()),
        picture_(tensor_of(problem.picture)) {
    at::set_num_threads(options.threads);
    const FoldedConvolutions folded(problem, options.weights);
    for (std::size_t i = 0; i < parameters_.size(); ++i) {
      const detect::LayerConfig& layer = problem.config.layers[i];
      for (const std::size_t input : detect::inputs_of(problem.config, i)) last_reader_[input] = i;
      if (layer.kind != detect::LayerKind::convolutional) continue;
      auto own = folded.read(i);
      const auto size = signed_count(layer.size);
      parameters_[i].weights =
          torch::from_blob(own.weights.data(),
                           {signed_count(layer.filters),
                            signed_count(input_channels(problem, i) / layer.groups), size, size})
              .clone(channels_last);
      parameters_[i].biases = torch::from_blob(own.biases.data(), {signed_count(layer.filters)}).clone();
    }
    for (const auto& weighting : problem.weighting) weighting_.push_back(tensor_of(weighting));
  }

  [[nodiscard]] std::string name() const { return "libtorch " TORCH_VERSION; }

  void run() {
    if (!wants_gradient_) {
      const c10::InferenceMode inference;
      forward(picture_);
      return;
    }
    const at::Tensor picture = picture_.detach().requires_grad_(true);
    forward(picture);
    gradient_ = torch::autograd::grad(logits_, {picture}, weighting_)[0];
  }

  [[nodiscard]] Answer answer() const {
    Answer answer;
    if (wants_gradient_) return {values_of(gradient_, {0, 1, 2, 3}), decisions()};
    for (const at::Tensor& logits : logits_) {
      const auto values = values_of(logits, {0, 1, 2, 3});
      append(answer.values, values.data(), values.size());
    }
    return answer;
  }

 private:
  struct Parameters {
    at::Tensor weights;
    at::Tensor biases;
  };

  /// Without a gradient, a value is forgotten after the last layer that reads it.
  void forward(const at::Tensor& picture) {
    logits_.clear();
    for (std::size_t i = 0; i < outputs_.size(); ++i) {
      outputs_[i] = layer_output(i, i == 0 ? picture : outputs_[i - 1]);
      if (problem_.config.layers[i].kind == detect::LayerKind::yolo) logits_.push_back(outputs_[i]);
      for (std::size_t earlier = 0; earlier < i && !wants_gradient_; ++earlier)
        if (last_reader_[earlier] <= i) outputs_[earlier] = at::Tensor();
    }
  }

  [[nodiscard]] at::Tensor layer_output(std::size_t i, const at::Tensor& input) const {
    const detect::LayerConfig& layer = problem_.config.layers[i];
    switch (layer.kind) {
      case detect::LayerKind::convolutional:
        return activated(i, at::conv2d(input, parameters_[i].weights, parameters_[i].biases,
                                       signed_count(layer.stride), signed_count(layer.padding),
                                       signed_count(layer.dilation), signed_count(layer.groups)));
      case detect::LayerKind::maxpool:
        return pooled(i, input);
      case detect::LayerKind::upsample:
        return at::upsample_nearest2d(
            input, {signed_count(problem_.shapes[i].height), signed_count(problem_.shapes[i].width)});
      case detect::LayerKind::route: {
        if (layer.groups != 1) throw not_supported(problem_, i);
        if (layer.sources.size() == 1) return outputs_[layer.sources.front()];
        std::vector<at::Tensor> parts;
        for (const std::size_t source : layer.sources) parts.push_back(outputs_[source]);
        return at::cat(parts, 1);
      }
      case detect::LayerKind::shortcut: {
        at::Tensor sum = input;
        for (const std::size_t source : layer.sources) sum = sum + outputs_[source];
        return activated(i, sum);
      }
      case detect::LayerKind::yolo:
      case detect::LayerKind::dropout:
        return input;
      default:
        throw not_supported(problem_, i);
    }
  }

  /// In place, which its autograd allows for these functions.
  [[nodiscard]] at::Tensor activated(std::size_t i, at::Tensor values) const {
    const float slope = slope_of(problem_, i);
    if (slope == 1) return values;
    return slope == 0 ? at::relu_(values) : at::leaky_relu_(values, slope);
  }

  [[nodiscard]] at::Tensor pooled(std::size_t i, at::Tensor input) const {
    const detect::LayerConfig& layer = problem_.config.layers[i];
    const auto before = signed_count(layer.padding / 2);
    const auto covered = [&](std::size_t cells) {
      return signed_count((cells - 1) * layer.stride + layer.size);
    };
    const auto after_row = covered(problem_.shapes[i].height) - before - input.size(2);
    const auto after_column = covered(problem_.shapes[i].width) - before - input.size(3);
    if (after_row == before && after_column == before && 2 * before <= signed_count(layer.size))
      return at::max_pool2d(input, signed_count(layer.size), signed_count(layer.stride), before);
    if (before > 0 || after_row > 0 || after_column > 0)
      input = at::constant_pad_nd(input, {before, after_column, before, after_row}, -1e30);
    return at::max_pool2d(input, signed_count(layer.size), signed_count(layer.stride));
  }

  [[nodiscard]] Decisions decisions() const {
    Decisions decisions = no_decisions(problem_);
    for (std::size_t i = 0; i < outputs_.size(); ++i) {
      const detect::LayerConfig& layer = problem_.config.layers[i];
      if (has_kink(layer)) {
        const auto values = values_of(outputs_[i], {0, 2, 3, 1});
        decisions.is_positive[i] = signs(values.data(), values.size());
      }
      if (layer.kind == detect::LayerKind::maxpool)
        decisions.chosen[i] = pool_choices(problem_, i, values_of(outputs_[i - 1], {0, 2, 3, 1}));
    }
    return decisions;
  }

  const Problem& problem_;
  bool wants_gradient_;
  std::vector<Parameters> parameters_;
  std::vector<at::Tensor> outputs_;
  std::vector<std::size_t> last_reader_;
  std::vector<at::Tensor> logits_;
  std::vector<at::Tensor> weighting_;
  at::Tensor picture_;
  at::Tensor gradient_;
};
}  // namespace
}  // namespace tapestry::benchmarks

int main(int argc, char** argv) {
  return tapestry::benchmarks::run_worker<tapestry::benchmarks::LibtorchDetector>(argc, argv, "folded-nhwc");
}

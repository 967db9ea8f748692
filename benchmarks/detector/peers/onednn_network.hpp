#pragma once
#include "onednn_forward.hpp"

namespace tapestry::benchmarks {
/// The detector in oneDNN, optionally with the gradient to its picture by backward-data convolutions.
class OneDnnNetwork : public OneDnnForward {
 public:
  OneDnnNetwork(const Problem& problem, const std::string& weights_path, bool wants_gradient,
                bool tries_winograd)
      : OneDnnForward(problem, weights_path, wants_gradient, tries_winograd),
        backward_(engine_),
        adjoints_(layer_count()) {
    if (!wants_gradient) return;
    gradient_ = zeros<float, 4>(problem.picture.shape());
    for (std::size_t i = layer_count(); i-- > 0;) plan_backward(i);
  }

  void run() {
    OneDnnForward::run();
    if (wants_gradient_) backward_.run();
  }

  [[nodiscard]] const Array<float, 4>& gradient() const { return gradient_; }

  /// "70 jit:avx2, …": the convolutions' kernels, the gradient's too.
  [[nodiscard]] std::string kernels() const {
    auto counts = forward_.kernels();
    for (const auto& [name, count] : backward_.kernels()) counts[name] += count;
    std::string text;
    for (const auto& [name, count] : counts)
      text += (text.empty() ? "" : ", ") + std::to_string(count) + " " + name;
    return text;
  }

 private:
  /// Adds a part of a value's adjoint; the first one becomes it.
  void add_adjoint(std::size_t value, const Value& part) {
    if (adjoints_[value].is_empty()) {
      adjoints_[value] = part;
      return;
    }
    const Value sum = adjoints_[value].is_shared() ? pool_.take(blocked(shape(value))) : adjoints_[value];
    append_sum(backward_, adjoints_[value].memory, part.memory, sum.memory);
    adjoints_[value] = sum;
  }

  void plan_backward(std::size_t i) {
    if (layer(i).kind == Kind::yolo) read_weighting(i);
    if (producer(i) != i || adjoints_[i].is_empty()) return;
    Value adjoint = std::move(adjoints_[i]);
    adjoints_[i] = Value();
    if (has_kink(layer(i))) adjoint = before_activation(i, adjoint);
    switch (layer(i).kind) {
      case Kind::convolutional:
        convolve_back(i, adjoint);
        break;
      case Kind::maxpool:
        max_pool_back(i, adjoint);
        break;
      case Kind::upsample: {
        const std::size_t in = inputs(i).front();
        const Value part = pool_.take(blocked(shape(in)));
        const dnnl::resampling_backward::desc back(dnnl::algorithm::resampling_nearest, blocked(shape(in)),
                                                   blocked(shape(i)));
        backward_.append(dnnl::resampling_backward({back, engine_, upsampling(i)}),
                         {{DNNL_ARG_DIFF_DST, adjoint.memory}, {DNNL_ARG_DIFF_SRC, part.memory}});
        add_adjoint(in, part);
        break;
      }
      case Kind::route:
        split_back(i, adjoint);
        break;
      default:  // a shortcut; others did not come past plan_forward()
        for (const std::size_t in : inputs(i)) add_adjoint(in, adjoint);
    }
  }

  void read_weighting(std::size_t i) {
    const auto head = std::find(problem_.heads.begin(), problem_.heads.end(), i) - problem_.heads.begin();
    const auto& weighting = problem_.weighting[static_cast<std::size_t>(head)];
    const dnnl::memory plain(description(shape(i), dnnl::memory::format_tag::nchw), engine_,
                             const_cast<float*>(weighting.data()));
    const Value part = pool_.take(blocked(shape(i)));
    backward_.append_reorder(plain, part.memory);
    add_adjoint(producer(i), part);
  }

  /// The adjoint multiplied by an activation's slope, which follows from the output's sign.
  [[nodiscard]] Value before_activation(std::size_t i, const Value& adjoint) {
    const auto values = blocked(shape(i));
    const float slope = slope_of(problem_, i);
    constexpr auto algorithm = dnnl::algorithm::eltwise_relu_use_dst_for_bwd;
    const dnnl::eltwise_forward::primitive_desc hint(
        {dnnl::prop_kind::forward_training, algorithm, values, slope}, engine_);
    const Value in = adjoint.is_shared() ? pool_.take(values) : adjoint;
    backward_.append(dnnl::eltwise_backward({{algorithm, values, values, slope}, engine_, hint}),
                     {{DNNL_ARG_DST, values_[i].memory},
                      {DNNL_ARG_DIFF_DST, adjoint.memory},
                      {DNNL_ARG_DIFF_SRC, in.memory}});
    return in;
  }

  void convolve_back(std::size_t i, const Value& adjoint) {
    const ConvolutionTask task = this->task(i);
    const auto back = backward_convolution(task, choice_.backward(task), engine_);
    FoldedConvolution folded = parameters_.read(i);
    const Value part = pool_.take(back.diff_src_desc());
    backward_.append(dnnl::convolution_backward_data(back),
                     {{DNNL_ARG_DIFF_DST, adjoint.memory},
                      {DNNL_ARG_WEIGHTS, reordered_weights(task, folded, back.weights_desc())},
                      {DNNL_ARG_DIFF_SRC, part.memory}});
    if (i == 0) {
      backward_.append_reorder(
          part.memory, {description(task.in, dnnl::memory::format_tag::nchw), engine_, gradient_.data()});
    } else if (back.diff_src_desc() == blocked(task.in)) {
      add_adjoint(inputs(i).front(), part);
    } else {
      const Value changed = pool_.take(blocked(task.in));
      backward_.append_reorder(part.memory, changed.memory);
      add_adjoint(inputs(i).front(), changed);
    }
  }

  void max_pool_back(std::size_t i, const Value& adjoint) {
    const std::size_t in = inputs(i).front();
    const dnnl::pooling_backward::desc back(dnnl::algorithm::pooling_max, blocked(shape(in)),
                                            blocked(shape(i)), both(layer(i).stride), both(layer(i).size),
                                            both(layer(i).padding / 2), pool_overhang(i));
    const Value part = pool_.take(blocked(shape(in)));
    backward_.append(dnnl::pooling_backward({back, engine_, pooling(i)}),
                     {{DNNL_ARG_DIFF_DST, adjoint.memory},
                      {DNNL_ARG_DIFF_SRC, part.memory},
                      {DNNL_ARG_WORKSPACE, notes_[i]}});
    add_adjoint(in, part);
  }

  /// Cuts a joined adjoint apart. Where a cut is not on a block's border, all of it is unblocked first.
  void split_back(std::size_t i, const Value& adjoint) {
    const auto in = inputs(i);
    const bool is_aligned = std::all_of(in.begin(), in.end(), [&](std::size_t input) {
      return shape(input).channels % block_channels() == 0;
    });
    Value whole = adjoint;
    if (!is_aligned) {
      whole = pool_.take(description(shape(i), dnnl::memory::format_tag::nchw));
      backward_.append_reorder(adjoint.memory, whole.memory);
    }
    dnnl::memory::dim begin = 0;
    for (const std::size_t input : in) {
      const auto extents = blocked(shape(input)).dims();
      const auto cut = whole.memory.get_desc().submemory_desc(extents, {0, begin, 0, 0});
      const Value part = pool_.take(blocked(shape(input)));
      backward_.append_reorder({cut, engine_, whole.memory.get_data_handle()}, part.memory);
      add_adjoint(input, part);
      begin += extents[1];
    }
  }

  Plan backward_;
  std::vector<Value> adjoints_;
  Array<float, 4> gradient_;
};
}  // namespace tapestry::benchmarks

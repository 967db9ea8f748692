#pragma once
#include <tapestry/nn/detail/network/operators/convolution.hpp>

namespace tapestry::nn {
/// ConvTranspose: the adjoint of the convolution that would make x of y, with the weights
/// [channel of x, channel of y of its group, row tap, column tap], plus a bias.
template <std::floating_point T>
class ConvolutionTranspose : public Operation<T> {
 public:
  /// \param plan  of the convolution from y to x; its bias is one of y
  explicit ConvolutionTranspose(const ConvolutionPlan<T>& plan)
      : Operation<T>({{{plan.images, plan.shape.rows.input, plan.shape.columns.input, plan.shape.in_channels},
                       ElementType::floating}}),
        plan_(plan),
        weights_(plan.shape),
        covers_(adjoint_covers_input(plan.shape)) {}

  void prepare(std::span<const TensorView<const T>> constants) override {
    if (!plan_.has_computed_weights) {
      weights_.set(constants[plan_.weight].values);
      static_cast<void>(weights_.adjoint());
    }
    if (!has_bias() || !constants[plan_.bias].is_there()) return;
    bias_.resize(plan_.shape.in_channels);
    std::copy_n(constants[plan_.bias].values, bias_.size(), bias_.data());
  }

  void forward(const ForwardCall<T>& call) const override {
    T* const out = call.outputs[0].values;
    const std::size_t channels = plan_.shape.in_channels, size = plan_.images * plan_.shape.in_size();
    const T* bias = nullptr;
    if (has_bias()) bias = bias_.empty() ? call.inputs[plan_.bias].values : bias_.data();
    Epilogue<T> end{};
    end.adds = !covers_;
    if (covers_) end.bias = bias;
    for (std::size_t i = 0; i < size && !covers_; i += channels)
      if (bias == nullptr) {
        std::fill_n(out + i, channels, T(0));
      } else {
        std::copy_n(bias, channels, out + i);
      }
    const auto convolve_parts = [&](const ConvolutionWeights<T>& weights) {
      for (const auto& part : weights.adjoint())
        convolve<T>(call.engine, part, plan_.images, call.inputs[0].values, end, out, plan_.shape.in_size());
    };
    with_weights(call.inputs, convolve_parts);
  }

  void adjoint(const AdjointCall<T>& call) const override {
    const T* const adjoint = call.output_adjoints[0].values;
    if (has_bias() && call.wants(plan_.bias))
      bias_adjoint(adjoint, call.output_adjoints[0].size() / plan_.shape.in_channels, plan_.shape.in_channels,
                   call.accumulate(plan_.bias));
    if (call.wants(plan_.weight)) {
      static thread_local Buffer<T> partial;
      convolution_weight_adjoint(plan_.shape, plan_.images, adjoint, call.inputs[0].values, partial,
                                 call.accumulate(plan_.weight));
    }
    if (!call.wants(0)) return;
    Epilogue<T> end{};
    end.adds = !call.is_uninitialised[0];
    with_weights(call.inputs, [&](const ConvolutionWeights<T>& weights) {
      convolve<T>(call.engine, weights.convolution(), plan_.images, adjoint, end,
                  call.input_adjoints[0].values, plan_.shape.out_size());
    });
    call.is_uninitialised[0] = false;
  }

  [[nodiscard]] AdjointReads adjoint_reads() const override {
    if (!plan_.has_computed_weights) return {};
    return {1U | std::uint64_t(1) << plan_.weight, 0};
  }
  [[nodiscard]] AdjointReads weight_adjoint_reads() const override { return {1, 0}; }
  [[nodiscard]] bool is_weight(std::size_t input) const override {
    return input == plan_.weight || input == plan_.bias;
  }

 private:
  [[nodiscard]] bool has_bias() const { return plan_.bias != plan_.no_operand; }

  template <class Body>
  void with_weights(std::span<const TensorView<const T>> inputs, Body body) const {
    if (!plan_.has_computed_weights) return body(weights_);
    ConvolutionWeights<T> own(plan_.shape);
    own.set(inputs[plan_.weight].values);
    body(own);
  }

  ConvolutionPlan<T> plan_;
  ConvolutionWeights<T> weights_;
  bool covers_;
  Buffer<T> bias_;
};

namespace detail {
/// One axis of the convolution whose adjoint this is: `output` is the extent given, `input` the extent
/// returned.
/// \throws ShapeError if nothing would be left
[[nodiscard]] inline AxisWindow transposed_axis(const KernelAttributes& window, std::size_t axis,
                                                std::size_t given, std::size_t extra,
                                                std::size_t wanted_extent) {
  using AutoPad = KernelAttributes::AutoPad;
  const std::size_t stride = window.strides[axis];
  const std::size_t whole = (given - 1) * stride + window.reach(axis) + extra;
  std::size_t before = window.before[axis], after = window.after[axis];
  const bool is_same = window.auto_pad == AutoPad::same_upper || window.auto_pad == AutoPad::same_lower;
  if (wanted_extent == 0 && is_same) wanted_extent = given * stride;
  if (wanted_extent != 0) {
    const std::size_t zeros = whole > wanted_extent ? whole - wanted_extent : 0;
    before = window.auto_pad == AutoPad::same_upper ? zeros / 2 : zeros - zeros / 2;
    after = zeros - before;
  }
  if (whole <= before + after) throw ShapeError("nothing is left inside the padding");
  const std::size_t extent = wanted_extent != 0 ? wanted_extent : whole - before - after;
  return {
      extent, given, window.taps[axis], stride, window.dilations[axis], static_cast<std::ptrdiff_t>(before)};
}

template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_convolution_transpose(OperatorContext& context) {
  const Shape& picture = picture_shape(context);
  const Shape& weights = context.input(1).shape;
  const std::int64_t group = context.integer("group", 1);
  if (weights.size() != 4 || size_of(weights) == 0 || weights[0] != picture[3] ||
      static_cast<std::size_t>(group) > weights[0] || weights[0] % static_cast<std::size_t>(group) != 0)
    throw ShapeError({"weights ", weights, " in ", group, " groups do not fit ", picture[3], " channels"});
  const KernelAttributes window = window_attributes(context, {weights[2], weights[3]});
  std::array<std::size_t, 2> extra{}, wanted{};
  read_extents(context, "output_padding", 2, extra.data());
  for (std::size_t axis = 0; axis < 2; ++axis)
    if (extra[axis] >= std::max(window.strides[axis], window.dilations[axis]))
      throw DomainError({"attribute 'output_padding' is ", extra[axis],
                         ", expected less than the stride or the dilation, ", window.strides[axis], " and ",
                         window.dilations[axis]});
  auto extents = context.integers("output_shape");
  if (extents.size() == 4) extents.erase(extents.begin(), extents.begin() + 2);  // batch and channels
  if (!extents.empty() && extents.size() != 2)
    throw DomainError("attribute 'output_shape' is not of two axes");
  for (std::size_t axis = 0; axis < extents.size(); ++axis)
    wanted[axis] = static_cast<std::size_t>(extents[axis]);
  ConvolutionPlan<T> plan;
  plan.images = picture[0];
  plan.shape.groups = static_cast<std::size_t>(group);
  plan.shape.in_channels = weights[1] * plan.shape.groups;
  plan.shape.out_channels = weights[0];
  plan.shape.rows = transposed_axis(window, 0, picture[1], extra[0], wanted[0]);
  plan.shape.columns = transposed_axis(window, 1, picture[2], extra[1], wanted[1]);
  plan.has_computed_weights = context.input(1).constant == nullptr;
  if (context.has_input(2)) {
    plan.bias = 2;
    require_bias(context, 2, plan.shape.in_channels);
  }
  return std::make_unique<ConvolutionTranspose<T>>(plan);
}
}  // namespace detail

/// ConvTranspose of pictures. If `output_shape` leaves an odd number of values to cut off, auto_pad
/// SAME_UPPER cuts the smaller half in front, as the standard requires; every other setting cuts the larger
/// half there.
template <std::floating_point T>
void add_convolution_transpose(OperatorTable<T>& table) {
  table["ConvTranspose"] = {
      LayoutRule::channels_last,
      1,
      false,
      {{2, 3}},
      detail::make_convolution_transpose<T>,
      convolution_ranges({{"output_padding", 0, largest_window}, {"output_shape", 1, largest_window}})};
}
}  // namespace tapestry::nn

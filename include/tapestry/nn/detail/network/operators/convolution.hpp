#pragma once
#include <tapestry/nn/detail/batch_norm.hpp>
#include <tapestry/nn/detail/convolution_weight_adjoint.hpp>
#include <tapestry/nn/detail/network/operators/convolution_plan.hpp>

namespace tapestry::nn {
/// Conv: activation(Σ x · weights + bias [+ addend]) [+ addend]; or the sums, times `slope` where an operand
/// is not above 0: the derivative of a leaky convolution along x.
template <std::floating_point T>
class Convolution : public Operation<T> {
 public:
  explicit Convolution(const ConvolutionPlan<T>& plan)
      : Operation<T>(
            {{{plan.images, plan.shape.rows.output, plan.shape.columns.output, plan.shape.out_channels},
              ElementType::floating}}),
        plan_(plan),
        weights_(plan.shape) {}

  void prepare(std::span<const TensorView<const T>> constants) override {
    if (!plan_.has_computed_weights) {
      weights_.set(constants[plan_.weight].values);
      static_cast<void>(weights_.convolution());
    }
    if (!has_bias() || !constants[plan_.bias].is_there()) return;
    bias_.resize(plan_.shape.out_channels);
    std::copy_n(constants[plan_.bias].values, bias_.size(), bias_.data());
  }

  void forward(const ForwardCall<T>& call) const override {
    const CallWeights weights(*this, call.inputs);
    const FusedActivation<T>& activation = plan_.activation;
    T* const out = call.outputs[0].values;
    const T* addend = has_addend() ? call.inputs[plan_.addend].values : nullptr;
    Epilogue<T> end{};
    if (has_bias()) end.bias = bias_.empty() ? call.inputs[plan_.bias].values : bias_.data();
    if (addend != nullptr && plan_.adds_first) {
      copy(addend, out, plan_.out_size(call.batch));
      end.adds = true;
      addend = nullptr;
    }
    const bool keeps_signs = call.keeps && activation.needs_signs();
    const bool fuses_signs = keeps_signs && fuses_bits<T>(plan_.shape);
    if (keeps_signs) call.state.bits.resize(block_count(plan_.out_size(call.batch), 8));
    if (plan_.signs != plan_.no_operand) return convolve_by_signs(call, weights->convolution(), end);
    if (fuses_signs) end.positive = call.state.bits.data();  // whole bytes a pixel; others follow below
    if (!keeps_signs || fuses_signs) end.addend = addend;
    end.slope = activation.slope;
    end.curve = activation.curve;
    if (call.keeps && activation.is_curve()) {
      call.state.values.resize(plan_.out_size(call.batch));
      end.slopes = call.state.values.data();
    }
    convolve<T>(call.engine, weights->convolution(), call.batch * plan_.images, call.inputs[0].values, end,
                out, plan_.shape.out_size(), window_of(call.window));
    if (!keeps_signs || fuses_signs) return;
    positive_bits(out, call.state.bits.data(), plan_.out_size(call.batch));
    if (addend != nullptr) add(addend, out, plan_.out_size(call.batch));
  }

  void adjoint(const AdjointCall<T>& call) const override {
    T* const adjoint = call.output_adjoints[0].values;
    if (!plan_.adds_first) add_to_addend_adjoint(call, adjoint);
    if (!call.is_scaled) pull_back_activation(call, adjoint);
    if (plan_.adds_first) add_to_addend_adjoint(call, adjoint);
    const std::size_t pixels = plan_.out_size(call.batch) / plan_.shape.out_channels;
    if (has_bias() && call.wants(plan_.bias))
      bias_adjoint(adjoint, pixels, plan_.shape.out_channels, call.accumulate(plan_.bias));
    if (call.wants(plan_.weight)) {
      static thread_local Buffer<T> partial;
      convolution_weight_adjoint(plan_.shape, call.batch * plan_.images, call.inputs[0].values, adjoint,
                                 partial, call.accumulate(plan_.weight));
    }
    if (!call.wants(0)) return;
    const CallWeights weights(*this, call.inputs);
    convolve_adjoint(call.engine, *weights, call.batch * plan_.images, adjoint, call.is_uninitialised[0],
                     call.input_adjoints[0].values, window_of(call.input_window), call.input_scale);
    call.is_uninitialised[0] = false;
  }

  [[nodiscard]] std::optional<MapWindow> window_reached(Engine engine, std::span<const MapWindow> changed,
                                                        bool with_adjoint) const override {
    if (plan_.has_computed_weights) return std::nullopt;
    const PackedConvolution<T>& packed = weights_.convolution();
    const OutputTile tile = tile_of(engine, packed);
    MapWindow window{outputs_reached(plan_.shape.rows, tile, changed[0].rows),
                     outputs_reached(plan_.shape.columns, tile, changed[0].columns)};
    if (has_addend()) window = hull(window, changed[plan_.addend]);
    if (!with_adjoint) return window;
    for (const PackedConvolution<T>& part : weights_.adjoint()) {
      const MapWindow outputs = outputs_inside(part, changed[0]);
      const OutputTile own = tile_of(engine, part);
      window.rows = hull(window.rows, inputs_needed(part.shape.rows, own, outputs.rows));
      window.columns = hull(window.columns, inputs_needed(part.shape.columns, own, outputs.columns));
    }
    return window;
  }
  /// Outputs that share a tile with the window are computed with it.
  [[nodiscard]] MapWindow window_read(Engine engine, std::size_t operand,
                                      const MapWindow& computed) const override {
    const OutputTile tile = tile_of(engine, weights_.convolution());
    const MapWindow tiles{aligned(computed.rows, tile.outputs, plan_.shape.rows.output),
                          aligned(computed.columns, tile.outputs, plan_.shape.columns.output)};
    if (operand != 0) return tiles;
    return {inputs_needed(plan_.shape.rows, tile, tiles.rows),
            inputs_needed(plan_.shape.columns, tile, tiles.columns)};
  }
  [[nodiscard]] double product_count() const override {
    return static_cast<double>(plan_.images * plan_.shape.rows.output * plan_.shape.columns.output) *
           static_cast<double>(plan_.shape.taps() * plan_.shape.group_in() * plan_.shape.out_channels);
  }

  [[nodiscard]] AdjointReads adjoint_reads() const override {
    if (!plan_.has_computed_weights) return {};
    return {1U | std::uint64_t(1) << plan_.weight, 0};
  }
  [[nodiscard]] AdjointReads weight_adjoint_reads() const override { return {1, 0}; }
  [[nodiscard]] bool is_differentiable(std::size_t input) const override { return input != plan_.signs; }
  [[nodiscard]] AdjointScale<T> adjoint_scale(const OperationState<T>& state) const override {
    if (has_addend() && !plan_.adds_first) return {};  // the addend's adjoint is not scaled
    if (plan_.activation.is_curve()) return {state.values.data()};
    if (!plan_.activation.needs_signs()) return {};
    return {nullptr, state.bits.data(), plan_.activation.slope};
  }
  [[nodiscard]] bool scales_adjoint(const AdjointScale<T>& scale) const override {
    return scales_whole(plan_.shape, scale);
  }
  [[nodiscard]] bool is_weight(std::size_t input) const override {
    return input == plan_.weight || input == plan_.bias;
  }
  [[nodiscard]] bool takes_batches() const override { return plan_.takes_batches; }

 private:
  /// The weights, packed for this call if the network computes them.
  class CallWeights {
   public:
    CallWeights(const Convolution& owner, std::span<const TensorView<const T>> inputs)
        : own_(owner.plan_.shape) {
      weights_ = &owner.weights_;
      if (!owner.plan_.has_computed_weights) return;
      own_.set(inputs[owner.plan_.weight].values);
      weights_ = &own_;
    }
    const ConvolutionWeights<T>& operator*() const { return *weights_; }
    const ConvolutionWeights<T>* operator->() const { return weights_; }

   private:
    ConvolutionWeights<T> own_;
    const ConvolutionWeights<T>* weights_;
  };

  void convolve_by_signs(const ForwardCall<T>& call, const PackedConvolution<T>& weights,
                         Epilogue<T> end) const {
    const std::size_t size = plan_.out_size(call.batch);
    T* const out = call.outputs[0].values;
    call.state.bits.resize(block_count(size, 8));
    positive_bits(call.inputs[plan_.signs].values, call.state.bits.data(), size);
    const bool fuses = fuses_bits<T>(plan_.shape);
    if (fuses) end.gate = call.state.bits.data();
    end.slope = fuses ? plan_.activation.slope : T(1);
    convolve<T>(call.engine, weights, call.batch * plan_.images, call.inputs[0].values, end, out,
                plan_.shape.out_size());
    if (!fuses) leaky_adjoint(call.state.bits.data(), plan_.activation.slope, out, out, size);
  }

  [[nodiscard]] bool has_bias() const { return plan_.bias != plan_.no_operand; }
  [[nodiscard]] bool has_addend() const { return plan_.addend != plan_.no_operand; }

  [[nodiscard]] static std::optional<MapWindow> window_of(const MapWindow* window) {
    return window == nullptr ? std::nullopt : std::optional(*window);
  }

  void pull_back_activation(const AdjointCall<T>& call, T* adjoint) const {
    const FusedActivation<T>& activation = plan_.activation;
    if (activation.is_curve()) {
      multiply(call.state.values.data(), adjoint, plan_.out_size(call.batch));
    } else if (activation.needs_signs()) {
      leaky_adjoint(call.state.bits.data(), activation.slope, adjoint, adjoint, plan_.out_size(call.batch));
    }
  }

  void add_to_addend_adjoint(const AdjointCall<T>& call, const T* adjoint) const {
    if (!has_addend() || !call.wants(plan_.addend)) return;
    T* const to = call.input_adjoints[plan_.addend].values;
    // Where input and addend are one value, only operand 0 counts as fresh.
    if (to == call.input_adjoints[0].values) static_cast<void>(call.accumulate(0));
    if (call.is_uninitialised[plan_.addend]) {
      copy(adjoint, to, plan_.out_size(call.batch));
      call.is_uninitialised[plan_.addend] = false;
    } else {
      add(adjoint, to, plan_.out_size(call.batch));
    }
  }

  ConvolutionPlan<T> plan_;
  ConvolutionWeights<T> weights_;
  Buffer<T> bias_;
};

/// Ranges of the attributes of a convolution, and of further ones.
[[nodiscard]] inline std::vector<AttributeRange> convolution_ranges(std::vector<AttributeRange> others = {}) {
  others.push_back({"group", 1, largest_extent});
  return window_ranges(std::move(others));
}

/// Conv, and FusedConv, which simplified() makes of a Conv and the nodes behind it. Operands of FusedConv: x,
/// addend or nothing, weights, bias. Attributes: Conv's, FusedActivation's, and `adds_first`; or `signs`, the
/// slope where the operand in the addend's place is not above 0.
template <std::floating_point T>
void add_convolution(OperatorTable<T>& table) {
  table["Conv"] = {LayoutRule::channels_last,
                   1,
                   false,
                   {{2, 3}},
                   [](OperatorContext& context) {
                     return std::make_unique<Convolution<T>>(detail::plan_convolution<T>(context, 1));
                   },
                   convolution_ranges()};
  table["FusedConv"] = {LayoutRule::channels_last,
                        2,
                        false,
                        {{3, 4}},
                        [](OperatorContext& context) {
                          ConvolutionPlan<T> plan = detail::plan_convolution<T>(context, 2);
                          plan.activation = fused_activation<T>(context);
                          plan.adds_first = context.flag("adds_first", 0);
                          if (context.has_attribute("signs")) {
                            plan.activation.slope = static_cast<T>(context.number("signs", 0));
                            plan.signs = 1;
                          } else if (context.has_input(1)) {
                            plan.addend = 1;
                          }
                          auto convolution = std::make_unique<Convolution<T>>(plan);
                          if (context.has_input(1) && context.input(1).shape != convolution->result_shape())
                            throw ShapeError({"the addend is ", context.input(1).shape, ", expected ",
                                              convolution->result_shape()});
                          return convolution;
                        },
                        convolution_ranges()};
}
}  // namespace tapestry::nn

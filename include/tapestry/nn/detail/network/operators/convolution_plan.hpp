#pragma once
#include <tapestry/nn/detail/network/operators/convolution_weights.hpp>
#include <tapestry/nn/detail/network/operators/kernel_attributes.hpp>

namespace tapestry::nn {
/// Plan of one convolution of a network: all of it except the values.
template <std::floating_point T>
struct ConvolutionPlan {
  ConvolutionShape shape{};
  std::size_t images = 1;
  std::size_t addend = no_operand;  ///< operand of the output's extents that is added to the result
  bool adds_first = false;          ///< adds before the activation, not after it
  std::size_t signs = no_operand;   ///< operand of the output's extents whose signs a leaky activation takes
  std::size_t weight = 1;           ///< operands
  std::size_t bias = no_operand;
  bool has_computed_weights = false;
  bool takes_batches = true;  ///< x and the addend are computed, weights and bias are not
  FusedActivation<T> activation{};

  static constexpr std::size_t no_operand = static_cast<std::size_t>(-1);
  [[nodiscard]] std::size_t out_size(std::size_t batch) const { return batch * images * shape.out_size(); }
};

namespace detail {
/// Extents of a convolution of pictures with weights [M, C/group, kH, kW].
/// \throws ShapeError if they do not fit
[[nodiscard]] inline ConvolutionShape convolution_shape(OperatorContext& context, const Shape& picture,
                                                        const Shape& weights) {
  const std::int64_t group = context.integer("group", 1);
  if (weights.size() != 4) throw ShapeError({"the weights are ", weights, ", expected four axes"});
  if (size_of(weights) == 0) throw ShapeError("the weights are empty");
  if (static_cast<std::size_t>(group) > weights[0] || weights[0] % static_cast<std::size_t>(group) != 0 ||
      weights[1] * static_cast<std::size_t>(group) != picture[3])
    throw ShapeError({"weights ", weights, " in ", group, " groups do not fit ", picture[3], " channels"});
  KernelAttributes window = window_attributes(context, {weights[2], weights[3]});
  ConvolutionShape shape;
  shape.rows = axis_window(window, 0, picture[1]);
  shape.columns = axis_window(window, 1, picture[2]);
  shape.in_channels = picture[3];
  shape.out_channels = weights[0];
  shape.groups = static_cast<std::size_t>(group);
  return shape;
}

inline void require_bias(const OperatorContext& context, std::size_t input, std::size_t channels) {
  if (context.input(input).shape != Shape{channels})
    throw ShapeError({"the bias is ", context.input(input).shape, ", expected [", channels, "]"});
}

/// \param weight  operand of the weights; behind it comes the bias
template <std::floating_point T>
[[nodiscard]] ConvolutionPlan<T> plan_convolution(OperatorContext& context, std::size_t weight) {
  ConvolutionPlan<T> plan;
  const Shape& picture = picture_shape(context);
  plan.shape = convolution_shape(context, picture, context.input(weight).shape);
  plan.images = picture[0];
  plan.weight = weight;
  plan.has_computed_weights = context.input(weight).constant == nullptr;
  for (std::size_t i = 0; i < context.inputs.size(); ++i)
    if (context.has_input(i) && (context.input(i).constant == nullptr) != (i < weight))
      plan.takes_batches = false;
  context.require_type(weight, ElementType::floating);
  if (!context.has_input(weight + 1)) return plan;
  plan.bias = weight + 1;
  require_bias(context, plan.bias, plan.shape.out_channels);
  return plan;
}
}  // namespace detail
}  // namespace tapestry::nn

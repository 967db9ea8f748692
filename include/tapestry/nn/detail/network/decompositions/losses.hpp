#pragma once
#include <tapestry/nn/detail/network/decomposition.hpp>

namespace tapestry::nn::detail {
/// Minus the logarithm of the probability of each element's class, times the class's weight; all of them,
/// their sum or their mean by weight. Source: onnx.ai, NegativeLogLikelihoodLoss.
/// \param logarithms  of probabilities, [N, classes, …]; the node's input 1 are classes, [N, …]
inline void decompose_likelihood(OperatorContext& context, Decomposer& parts, const std::string& logarithms) {
  const Shape& classes = context.input(1).shape;
  if (const Shape& shape = context.input(0).shape; shape.size() < 2 || classes.size() + 1 != shape.size())
    throw ShapeError({"scores ", shape, " of classes ", classes, ", expected an axis more"});
  const std::string reduction = context.text("reduction", "mean");
  if (reduction != "none" && reduction != "sum" && reduction != "mean")
    throw DomainError({"attribute 'reduction' is ", in_quotes(reduction), ", expected none, sum or mean"});
  std::string target = parts.input(1), weights, ignored;
  if (context.has_attribute("ignore_index")) {
    const std::int64_t left_out = context.integer("ignore_index", 0);
    ignored = parts.add("Equal", {target, parts.integers({left_out})});
    target = parts.add("Where", {ignored, parts.integers({0}), target});
  }
  if (context.has_input(2))
    weights = parts.add("Gather", {parts.input(2), target}, {{"axis", std::int64_t{0}}});
  if (!ignored.empty())
    weights = parts.add("Where", {ignored, parts.number(0), weights.empty() ? parts.number(1) : weights});
  const std::string picked =
      parts.add("GatherElements", {logarithms, parts.raised(target, 1)}, {{"axis", std::int64_t{1}}});
  std::string losses = parts.add("Neg", {parts.reshaped(picked, classes)});
  if (!weights.empty()) losses = parts.add("Mul", {losses, weights});
  if (reduction == "none") return parts.finish(0, "Identity", {losses});
  std::vector<std::int64_t> axes;
  for (std::size_t axis = 0; axis < classes.size(); ++axis) axes.push_back(static_cast<std::int64_t>(axis));
  const std::string sum = parts.reduced("ReduceSum", losses, axes, false);
  if (reduction == "sum") return parts.finish(0, "Identity", {sum});
  const std::string count = weights.empty() ? parts.number(static_cast<double>(size_of(classes)))
                                            : parts.reduced("ReduceSum", weights, axes, false);
  parts.finish(0, "Div", {sum, count});
}

inline void decompose_negative_log_likelihood(OperatorContext& context, Decomposer& parts) {
  decompose_likelihood(context, parts, parts.input(0));
}

/// The same of a softmax over the classes; result 1 are the logarithms of its probabilities.
/// Source: onnx.ai, SoftmaxCrossEntropyLoss.
inline void decompose_softmax_cross_entropy(OperatorContext& context, Decomposer& parts) {
  const std::string logarithms = parts.add("LogSoftmax", {parts.input(0)}, {{"axis", std::int64_t{1}}});
  parts.finish(1, "Identity", {logarithms});
  decompose_likelihood(context, parts, logarithms);
}
}  // namespace tapestry::nn::detail

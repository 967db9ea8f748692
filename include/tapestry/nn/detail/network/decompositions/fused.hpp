#pragma once
#include <cstddef>
#include <cstdint>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/nn/detail/network/decomposition.hpp>
#include <vector>

namespace tapestry::nn::detail {

/// x · σ(alpha · x), as ONNX Runtime's optimiser writes SiLU.
inline void decompose_quick_gelu(OperatorContext& context, Decomposer& parts) {
  const double alpha = context.number("alpha", 1.702);
  const std::string& x = parts.input(0);
  const std::string inner = alpha == 1 ? x : parts.add("Mul", {x, parts.number(alpha)});
  parts.finish(0, "Mul", {x, parts.add("Sigmoid", {inner})});
}

/// x / √(mean of x² + epsilon) · scale over the axes from `axis` on. Source: onnx.ai, RMSNormalization.
inline void decompose_rms_normalization(OperatorContext& context, Decomposer& parts) {
  const auto rank = static_cast<std::int64_t>(context.input(0).shape.size());
  const auto first = static_cast<std::int64_t>(context.axis(context.integer("axis", -1), context.input(0).shape.size()));
  const double epsilon = context.number("epsilon", 1e-5);
  context.ignore("stash_type");
  std::vector<std::int64_t> axes;
  for (std::int64_t axis = first; axis < rank; ++axis) axes.push_back(axis);
  const std::string& x = parts.input(0);
  const std::string mean = parts.add("ReduceMean", {parts.add("Mul", {x, x}), parts.integers(axes)});
  const std::string root = parts.add("Sqrt", {parts.add("Add", {mean, parts.number(epsilon)})});
  parts.finish(0, "Mul", {parts.add("Div", {x, root}), parts.input(1)});
}

}  // namespace tapestry::nn::detail

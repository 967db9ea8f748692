#pragma once
#include <tapestry/nn/detail/network/decomposition.hpp>

namespace tapestry::nn::detail {

/// Whether a convolution or pooling runs along one axis, [N, C, L].
[[nodiscard]] inline bool has_one_axis(const OperatorContext& context) {
  return context.has_input(0) && context.input(0).shape.size() == 3;
}

/// The same along a row of a picture of height 1, [N, C, 1, L].
inline void decompose_along_one_axis(OperatorContext& context, Decomposer& parts) {
  const Node& node = parts.node();
  for (std::size_t i = 1; i < node.outputs.size(); ++i)
    if (!node.outputs[i].empty()) throw DomainError({"result ", i, " is not supported along one axis"});
  const auto raised = [&](std::size_t i) {
    const Shape& shape = context.input(i).shape;
    if (shape.size() != 3) throw ShapeError({"input ", i, " is ", shape, ", expected three axes"});
    return parts.reshaped(parts.input(i), {shape[0], shape[1], 1, shape[2]});
  };
  Decomposer::Names inputs{raised(0)};
  if (context.has_input(1)) inputs.push_back(raised(1));
  for (std::size_t i = 2; i < node.inputs.size(); ++i) inputs.push_back(node.inputs[i]);
  Decomposer::Attributes attributes = node.attributes;
  for (auto& [name, value] : attributes) {
    context.ignore(name);
    auto* const numbers = std::get_if<std::vector<std::int64_t>>(&value);
    if (numbers == nullptr) continue;
    const std::size_t expected = name == "pads" ? 2 : 1;
    if (numbers->size() != expected)
      throw ShapeError(
          {"attribute ", in_quotes(name), " has ", numbers->size(), " numbers, expected ", expected});
    const std::int64_t neutral = name == "pads" || name == "output_padding" ? 0 : 1;
    if (name == "pads")
      *numbers = {0, (*numbers)[0], 0, (*numbers)[1]};
    else
      numbers->insert(numbers->begin(), neutral);
  }
  const std::string flat = parts.add(node.operation.c_str(), std::move(inputs), std::move(attributes));
  parts.squeeze(0, flat, 2);
}

}  // namespace tapestry::nn::detail

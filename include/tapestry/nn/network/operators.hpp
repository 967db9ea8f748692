#pragma once
#include <concepts>
#include <cstddef>
#include <functional>
#include <limits>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <tapestry/nn/network/operation.hpp>
#include <tapestry/nn/network/operator_context.hpp>
#include <utility>

namespace tapestry::nn {

/// Storage order of tensors of four axes that an operator requires.
enum class LayoutRule {
  plain,          ///< as ONNX numbers the axes, [N, C, H, W]
  any,            ///< either, but the same for all data operands
  channels_last,  ///< [N, H, W, C]: what the kernels of convolution and pooling work on
};

inline constexpr std::size_t all_inputs = std::numeric_limits<std::size_t>::max();

/// An operator: the layout of its tensors, and the function that makes an operation of a node.
template <std::floating_point T>
struct Operator {
  using Maker = std::function<std::unique_ptr<Operation<T>>(OperatorContext&)>;

  LayoutRule layout = LayoutRule::plain;
  std::size_t data_inputs = all_inputs;  ///< number of leading tensors; the others are settings
  bool broadcasts = false;               ///< data operands of fewer axes get leading ones of extent 1
  Maker make{};                          ///< \throws DomainError or ShapeError for unsupported nodes
};

/// Operators by their names.
template <std::floating_point T>
using OperatorTable = std::map<std::string, Operator<T>, std::less<>>;

/// Every operator that a network may use.
template <std::floating_point T>
[[nodiscard]] const OperatorTable<T>& operators();

}  // namespace tapestry::nn

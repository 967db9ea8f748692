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

/// How an operator wants tensors of four axes stored.
enum class LayoutRule {
  plain,          ///< as ONNX numbers the axes, [N, C, H, W]
  any,            ///< all data operands alike, whichever way
  channels_last,  ///< [N, H, W, C]: what the kernels of convolution and pooling work on
};

inline constexpr std::size_t all_inputs = std::numeric_limits<std::size_t>::max();

/// An operator: how its tensors are to lie, and what makes an operation of a node.
template <std::floating_point T>
struct Operator {
  using Maker = std::function<std::unique_ptr<Operation<T>>(OperatorContext&)>;

  LayoutRule layout = LayoutRule::plain;
  std::size_t data_inputs = all_inputs;  ///< the first so many operands are tensors, the others settings
  bool broadcasts = false;               ///< data operands of fewer axes get leading ones of extent 1
  Maker make{};                          ///< \throws DomainError or ShapeError for what it does not support
};

/// Operators by their names.
template <std::floating_point T>
using OperatorTable = std::map<std::string, Operator<T>, std::less<>>;

/// Every operator that networks may be made of.
template <std::floating_point T>
[[nodiscard]] const OperatorTable<T>& operators();

}  // namespace tapestry::nn

#pragma once
#include <tapestry/nn/detail/network/operation.hpp>
#include <tapestry/nn/detail/network/operator_context.hpp>

namespace tapestry::nn {
/// Storage order of tensors of four axes that an operator requires.
enum class LayoutRule {
  plain,          ///< as ONNX numbers the axes, [N, C, H, W]
  any,            ///< either, but the same for all data operands
  channels_last,  ///< [N, H, W, C]: the layout of kernels of convolution and pooling
};

inline constexpr std::size_t all_inputs = std::numeric_limits<std::size_t>::max();

/// Number of operands of a node, in the versions of ONNX's operators from `opset` to that of the next entry.
struct OperandCount {
  std::size_t least = 1;
  std::size_t most = 1;  ///< all_inputs: any number
  std::int64_t opset = 1;
};

/// Largest extent, count or factor that a node may state: 2^31 − 1.
inline constexpr std::int64_t largest_extent = std::numeric_limits<std::int32_t>::max();

/// Values of an attribute that is an integer or a list of integers.
struct AttributeRange {
  const char* name = "";
  std::int64_t least = 0, most = 0;
};

/// An operator: its operands and attributes, the layout of its tensors, and the function that makes an
/// operation of a node. Make operations by made_operation(), which holds nodes against the first two.
template <std::floating_point T>
struct Operator {
  using Maker = std::function<std::unique_ptr<Operation<T>>(OperatorContext&)>;

  LayoutRule layout = LayoutRule::plain;
  std::size_t data_inputs = all_inputs;  ///< number of leading tensors; the others are settings
  bool broadcasts = false;               ///< data operands of fewer axes get leading ones of extent 1
  std::vector<OperandCount> operands{};  ///< the oldest version first
  Maker make{};                          ///< \throws DomainError or ShapeError for unsupported nodes
  std::vector<AttributeRange> ranges{};
};

/// Number of operands of a node, each with `is_there`; empty places at the end do not count.
template <class Operands>
[[nodiscard]] std::size_t operand_count(const Operands& operands) {
  std::size_t count = operands.size();
  while (count > 0 && !operands[count - 1].is_there) --count;
  return count;
}

/// \throws DomainError with both numbers unless a version of an operator takes so many operands
void require_operand_count(std::size_t count, std::int64_t opset, const std::vector<OperandCount>& expected);

/// \throws DomainError naming an attribute and a value out of its range
void require_ranges(const Node& node, const std::vector<AttributeRange>& ranges);

/// The operation of a node.
/// \throws DomainError or ShapeError for a node that the operator does not take, or that is not supported
template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> made_operation(const Operator<T>& kind,
                                                           OperatorContext& context) {
  require_operand_count(operand_count(context.inputs), context.opset(), kind.operands);
  require_ranges(context.node(), kind.ranges);
  auto operation = kind.make(context);
  context.require_all_asked();
  return operation;
}

/// Operators by their names.
template <std::floating_point T>
using OperatorTable = std::map<std::string, Operator<T>, std::less<>>;

/// Every operator that a network may use.
template <std::floating_point T>
[[nodiscard]] const OperatorTable<T>& operators();
}  // namespace tapestry::nn

#pragma once
#include <cstddef>
#include <cstdint>
#include <tapestry/nn/network/operators.hpp>
#include <vector>

namespace tapestry::nn {

/// Elements that all folded results of a network may have together, beside four for each that its constants
/// have: 256 MiB in double.
inline constexpr std::size_t largest_folded_size = std::size_t(1) << 25U;

/// An operand of a node that is folded.
struct FoldOperand {
  const Constant* constant = nullptr;  ///< null for Shape and Size, which read the extents alone
  Shape shape{};
  bool is_there = false;
};

namespace detail {
[[nodiscard]] inline Constant integers(std::vector<double> values, Shape shape) {
  return {std::move(shape), ElementType::integer, std::move(values)};
}

/// Whether the operator works on channels last, as its operands of four axes then must lie.
[[nodiscard]] bool lies_last(const Operator<double>& kind, const std::vector<FoldOperand>& operands);
}  // namespace detail

/// The results of a node all of whose operands are known, computed in double.
/// \param most  elements that they may have
/// \throws DomainError or ShapeError if the node is not supported or its results are too large
[[nodiscard]] std::vector<Constant> fold_node(const Node& node, std::int64_t opset,
                                              const std::vector<FoldOperand>& operands, std::size_t most);

}  // namespace tapestry::nn

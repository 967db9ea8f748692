#pragma once
/// \file
#include <algorithm>
#include <array>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string>
#include <tapestry/core/error.hpp>
#include <tapestry/core/in_quotes.hpp>
#include <tapestry/nn/network/layout_conversion.hpp>
#include <tapestry/nn/network/operators.hpp>
#include <tapestry/nn/network/operators/batch_normalization.hpp>
#include <tapestry/nn/network/operators/binary.hpp>
#include <tapestry/nn/network/operators/channel_shuffle.hpp>
#include <tapestry/nn/network/operators/convolution.hpp>
#include <tapestry/nn/network/operators/convolution_transpose.hpp>
#include <tapestry/nn/network/operators/gather.hpp>
#include <tapestry/nn/network/operators/gemm.hpp>
#include <tapestry/nn/network/operators/generators.hpp>
#include <tapestry/nn/network/operators/grid_sample.hpp>
#include <tapestry/nn/network/operators/group_normalization.hpp>
#include <tapestry/nn/network/operators/layer_normalization.hpp>
#include <tapestry/nn/network/operators/matmul.hpp>
#include <tapestry/nn/network/operators/non_max_suppression.hpp>
#include <tapestry/nn/network/operators/order.hpp>
#include <tapestry/nn/network/operators/pad.hpp>
#include <tapestry/nn/network/operators/pass_on.hpp>
#include <tapestry/nn/network/operators/pixel_unshuffle.hpp>
#include <tapestry/nn/network/operators/pooling.hpp>
#include <tapestry/nn/network/operators/reduce.hpp>
#include <tapestry/nn/network/operators/reshape.hpp>
#include <tapestry/nn/network/operators/resize.hpp>
#include <tapestry/nn/network/operators/scatter.hpp>
#include <tapestry/nn/network/operators/softmax.hpp>
#include <tapestry/nn/network/operators/unary.hpp>
#include <tapestry/nn/network/operators/variadic.hpp>
#include <tapestry/nn/network/operators/views.hpp>
#include <tapestry/nn/network/program_builder.hpp>
#include <variant>
#include <vector>

/// The table of operators.hpp. It includes every operator and so takes a compiler long.

namespace tapestry::nn {

template <std::floating_point T>
const OperatorTable<T>& operators() {
  static const OperatorTable<T> table = [] {
    OperatorTable<T> all;
    add_pass_on(all);
    add_convolution(all);
    add_channel_shuffle(all);
    add_pixel_unshuffle(all);
    add_interleave_channels(all);
    add_unary_operators(all);
    add_binary_operators(all);
    add_variadic_operators(all);
    add_max_pool(all);
    add_average_pool(all);
    add_resize(all);
    add_grid_sample(all);
    add_local_response_normalization(all);
    add_layer_normalization(all);
    add_group_normalization(all);
    add_batch_normalization(all);
    add_matmul(all);
    add_gemm(all);
    add_convolution_transpose(all);
    add_reshape_operators(all);
    add_view_operators(all);
    add_pad_operators(all);
    add_gather_operators(all);
    add_scatter_operators(all);
    add_cast_operators(all);
    add_generators(all);
    add_reduce_operators(all);
    add_softmax_operators(all);
    add_order_operators(all);
    add_non_max_suppression(all);
    return all;
  }();
  return table;
}

template const OperatorTable<float>& operators<float>();
template const OperatorTable<double>& operators<double>();

}  // namespace tapestry::nn

namespace tapestry::nn {

void require_operand_count(std::size_t count, std::int64_t opset, const std::vector<OperandCount>& expected) {
  OperandCount own{0, 0};
  for (const OperandCount& version : expected)
    if (version.opset <= opset) own = version;
  if (count >= own.least && count <= own.most) return;
  const std::string least = std::to_string(own.least);
  throw DomainError(std::to_string(count) + " operands, expected " +
                    (own.most == own.least    ? least
                     : own.most == all_inputs ? "at least " + least
                                              : least + " to " + std::to_string(own.most)));
}

void require_ranges(const Node& node, const std::vector<AttributeRange>& ranges) {
  for (const AttributeRange& range : ranges) {
    const auto found = node.attributes.find(range.name);
    if (found == node.attributes.end()) continue;
    const auto require = [&](std::int64_t value) {
      if (value < range.least || value > range.most)
        throw DomainError("attribute " + in_quotes(range.name) +
                          " is out of range: " + std::to_string(value) + ", expected " +
                          std::to_string(range.least) + " to " + std::to_string(range.most));
    };
    if (const auto* value = std::get_if<std::int64_t>(&found->second)) require(*value);
    if (const auto* values = std::get_if<std::vector<std::int64_t>>(&found->second))
      std::ranges::for_each(*values, require);
  }
}

}  // namespace tapestry::nn

namespace tapestry::nn::detail {

/// Extents first … end − 1 of an operand, which may count from the end.
[[nodiscard]] inline Constant shape_constant(const Node& node, std::int64_t opset, const Shape& shape) {
  OperatorContext context(node, opset, {}, false);
  const auto rank = static_cast<std::int64_t>(shape.size());
  const auto place = [&](std::int64_t axis) {
    return std::clamp<std::int64_t>(axis < 0 ? axis + rank : axis, 0, rank);
  };
  const std::int64_t first = place(context.integer("start", 0)), end = place(context.integer("end", rank));
  context.require_all_asked();
  std::vector<double> extents;
  for (std::int64_t i = first; i < end; ++i)
    extents.push_back(static_cast<double>(shape[static_cast<std::size_t>(i)]));
  const std::size_t count = extents.size();
  return integers(std::move(extents), {count});
}

bool lies_last(const Operator<double>& kind, const std::vector<FoldOperand>& operands) {
  if (kind.layout != LayoutRule::channels_last) return false;
  bool has_four = false, fits = true;
  for (std::size_t i = 0; i < std::min(kind.data_inputs, operands.size()); ++i) {
    has_four = has_four || (operands[i].is_there && operands[i].shape.size() == 4);
    fits = fits && (!operands[i].is_there || operands[i].shape.size() == 4);
  }
  return has_four && fits;
}

}  // namespace tapestry::nn::detail

namespace tapestry::nn {

namespace detail {

/// Operands as the kernels read them: readable past their ends.
struct FoldInputs {
  std::vector<Constant> stored;
  std::vector<Buffer<double>> values;
  std::vector<TensorView<const double>> views;

  /// \param first_last  number of leading operands to store channels last
  FoldInputs(const std::vector<FoldOperand>& operands, std::size_t first_last)
      : stored(operands.size()), values(operands.size()), views(operands.size()) {
    for (std::size_t i = 0; i < operands.size(); ++i) {
      if (!operands[i].is_there) continue;
      stored[i] = i < first_last ? to_channels_last(*operands[i].constant) : *operands[i].constant;
      values[i].resize(stored[i].size());
      for (std::size_t k = 0; k < values[i].size(); ++k) values[i].data()[k] = stored[i].at(k);
      views[i] = {&stored[i].shape, values[i].data()};
    }
  }

  /// The operands as the maker of an operation takes them.
  [[nodiscard]] std::vector<Operand> described(const std::vector<FoldOperand>& operands) const {
    std::vector<Operand> made;
    for (std::size_t i = 0; i < stored.size(); ++i) {
      const bool is_there = operands[i].is_there;
      made.push_back({stored[i].shape, stored[i].type, is_there ? &stored[i] : nullptr, is_there});
    }
    return made;
  }
};

}  // namespace detail

std::vector<Constant> fold_node(const Node& node, std::int64_t opset,
                                const std::vector<FoldOperand>& operands, std::size_t most) {
  if (node.operation == "Shape" || node.operation == "Size") {
    require_operand_count(operand_count(operands), opset, {{1, 1}});
    const Shape& shape = operands.front().shape;
    if (node.operation == "Shape") return {detail::shape_constant(node, opset, shape)};
    return {detail::integers({static_cast<double>(size_of(shape))}, {})};
  }
  const Operator<double>& kind = operators<double>().find(node.operation)->second;
  const bool is_last = detail::lies_last(kind, operands);
  const detail::FoldInputs inputs(operands, is_last ? kind.data_inputs : 0);
  OperatorContext context(node, opset, inputs.described(operands), is_last);
  const auto operation = made_operation(kind, context);
  std::vector<Buffer<double>> results;
  std::vector<TensorView<double>> result_views;
  for (const auto& result : operation->results()) {
    const std::size_t count = size_of(result.shape);
    if (count > most)
      throw ShapeError("a constant result " + tapestry::detail::to_text(result.shape) + " is too large");
    most -= count;
    results.emplace_back(count);
    result_views.push_back({&result.shape, results.back().data()});
  }
  operation->prepare(inputs.views);
  OperationState<double> state;
  operation->forward({inputs.views, result_views, state, false, Engine::automatic});
  std::vector<Constant> constants;
  for (std::size_t i = 0; i < results.size(); ++i) {
    Constant result{operation->results()[i].shape, operation->results()[i].type,
                    std::vector<double>(results[i].data(), results[i].data() + results[i].size())};
    constants.push_back(is_last && result.shape.size() == 4 ? from_channels_last(result) : std::move(result));
  }
  return constants;
}

}  // namespace tapestry::nn

#pragma once
#include <tapestry/nn/detail/network/axis_reduction.hpp>
#include <tapestry/nn/detail/network/operation.hpp>
#include <tapestry/nn/pointwise.hpp>

namespace tapestry::nn {
/// The common extents of two tensors. Axes are counted from the last one; an axis of extent 1, or a missing
/// one, is repeated. Source: onnx.ai, Broadcasting.
/// \throws ShapeError naming both if they do not go together
[[nodiscard]] inline Shape broadcast_shape(const Shape& a, const Shape& b) {
  Shape shape(std::max(a.size(), b.size()), 1);
  for (std::size_t i = 1; i <= shape.size(); ++i) {
    const std::size_t x = i <= a.size() ? a[a.size() - i] : 1, y = i <= b.size() ? b[b.size() - i] : 1;
    if (x != y && x != 1 && y != 1) throw ShapeError({"operands of ", a, " and ", b, " do not go together"});
    shape[shape.size() - i] = x == 1 ? y : x;
  }
  return shape;
}

/// Steps of a tensor that is repeated to `shape`: 0 along the repeated axes.
[[nodiscard]] inline std::vector<std::ptrdiff_t> broadcast_strides(const Shape& operand, const Shape& shape) {
  const auto own = strides_of(operand);
  std::vector<std::ptrdiff_t> strides(shape.size(), 0);
  for (std::size_t i = 1; i <= operand.size() && i <= shape.size(); ++i)
    if (operand[operand.size() - i] != 1) strides[shape.size() - i] = own[own.size() - i];
  return strides;
}

/// A result of `shape`, tensor 0, and operands that are repeated to it. Innermost strides are 1, or 0 where
/// an operand stays.
template <std::size_t Operands>
[[nodiscard]] LoopNest<Operands + 1> broadcast_nest(const Shape& shape,
                                                    const std::array<const Shape*, Operands>& operands) {
  LoopNest<Operands + 1> nest;
  const auto own = strides_of(shape);
  for (std::size_t axis = 0; axis < shape.size(); ++axis) nest.loops.push_back({shape[axis], {own[axis]}});
  for (std::size_t i = 0; i < Operands; ++i) {
    const auto strides = broadcast_strides(*operands[i], shape);
    for (std::size_t axis = 0; axis < shape.size(); ++axis) nest.loops[axis].strides[i + 1] = strides[axis];
  }
  nest.simplify();
  return nest;
}

/// Adjoint of an operand that was repeated to a result.
struct BroadcastOperand {
  bool is_whole = true;  ///< it was not repeated
  AxisReduction reduction{};

  BroadcastOperand() = default;
  BroadcastOperand(const Shape& operand, const Shape& shape) : is_whole(size_of(operand) == size_of(shape)) {
    if (is_whole) return;
    const auto strides = broadcast_strides(operand, shape);
    std::vector<bool> is_reduced(shape.size());
    for (std::size_t axis = 0; axis < shape.size(); ++axis)
      is_reduced[axis] = strides[axis] == 0 && shape[axis] != 1;
    reduction = AxisReduction(shape, is_reduced, strides);
  }

  /// Adds scale · from, of the result's extents and summed over the repetitions, to an operand's adjoint.
  template <std::floating_point T>
  void pull_back(const T* from, T scale, const AdjointCall<T>& call, std::size_t input) const {
    T* const to = call.input_adjoints[input].values;
    const std::size_t count = call.input_adjoints[input].size();
    const bool is_uninitialised = call.is_uninitialised[input];
    call.is_uninitialised[input] = false;
    if (!is_whole) return sum_to(reduction, from, static_cast<double>(scale), is_uninitialised, to);
    if (scale == T(1)) return is_uninitialised ? copy(from, to, count) : add(from, to, count);
    detail::for_each_block(count, [&](std::size_t begin, std::size_t size) {
      for (std::size_t i = begin; i < begin + size; ++i)
        to[i] = scale * from[i] + (is_uninitialised ? T(0) : to[i]);
    });
  }
};

/// Repeats an operand, tensor 1 of the nest, to its result's extents.
template <std::floating_point T>
void repeat(const LoopNest<2>& nest, const T* from, T* to) {
  const bool moves = nest.loops.back().strides[1] != 0;
  parallel_for_each_run(nest, [&](const auto& at, std::size_t count) {
    if (moves) {
      std::memcpy(to + at[0], from + at[1], count * sizeof(T));
    } else {
      std::fill_n(to + at[0], count, from[at[1]]);
    }
  });
}
}  // namespace tapestry::nn

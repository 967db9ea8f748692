#pragma once
#include <tapestry/nn/detail/network/operators/reshape.hpp>

namespace tapestry::nn {
/// Blocks of neighbouring elements of a tensor that some indices select.
struct IndexPlan {
  LoopNest<2> nest{};                     ///< loops over the blocks: places among indices, and in the tensor
  std::vector<std::ptrdiff_t> strides{};  ///< step in the tensor for one unit of each index of a block
  Shape extents{};                        ///< extent of the axis of each of these indices
  std::size_t block = 1;                  ///< elements of a block
  std::size_t count = 1;                  ///< number of blocks

  /// Writes where each block begins. \throws DomainError for an index out of range
  template <std::floating_point T>
  void write_places(const T* indices, ElementIndex<T>* places) const {
    const auto step = nest.loops.back().strides;
    for_each_run(nest, [&](const auto& at, std::size_t run) {
      for (std::size_t i = 0; i < run; ++i) {
        const auto k = static_cast<std::ptrdiff_t>(i);
        const T* const index = indices + at[0] + k * step[0];
        std::ptrdiff_t place = at[1] + k * step[1];
        for (std::size_t j = 0; j < strides.size(); ++j) place += offset(index[j], j);
        *places++ = static_cast<ElementIndex<T>>(place);
      }
    });
  }

  /// One index along an axis; a block is everything behind that axis.
  [[nodiscard]] static IndexPlan of_axis(const Shape& shape, std::size_t axis, std::size_t index_count) {
    IndexPlan plan;
    const std::ptrdiff_t stride = strides_of(shape)[axis];
    const auto outer = static_cast<std::ptrdiff_t>(shape[axis]) * stride;
    plan.nest.loops = {
        {size_of({shape.begin(), shape.begin() + static_cast<std::ptrdiff_t>(axis)}), {0, outer}},
        {index_count, {1, 0}}};
    plan.strides = {stride};
    plan.extents = {shape[axis]};
    plan.block = static_cast<std::size_t>(stride);
    return plan.finished();
  }

  /// One index along an axis for each element; its other coordinates are the index's.
  [[nodiscard]] static IndexPlan of_elements(const Shape& shape, std::size_t axis, const Shape& indices) {
    IndexPlan plan;
    const auto own = strides_of(shape), steps = strides_of(indices);
    if (shape.size() != indices.size()) throw ShapeError({"indices are ", indices, " for ", shape});
    for (std::size_t i = 0; i < shape.size(); ++i) {
      if (i != axis && indices[i] > shape[i]) throw ShapeError({"indices are ", indices, " for ", shape});
      plan.nest.loops.push_back({indices[i], {steps[i], i == axis ? 0 : own[i]}});
    }
    plan.strides = {own[axis]};
    plan.extents = {shape[axis]};
    return plan.finished();
  }

  /// Several indices for the axes behind the first `batch`; a block is everything behind those axes.
  [[nodiscard]] static IndexPlan of_tuples(const Shape& shape, std::size_t batch, const Shape& indices) {
    IndexPlan plan;
    const std::size_t size = indices.empty() ? 0 : indices.back();
    const std::string both = tapestry::detail::to_text(indices) + " for " + tapestry::detail::to_text(shape);
    if (indices.empty() || batch >= indices.size() || batch + size > shape.size() || size == 0)
      throw ShapeError({"indices are ", both});
    const auto own = strides_of(shape), steps = strides_of(indices);
    for (std::size_t i = 0; i + 1 < indices.size(); ++i) {
      if (i < batch && indices[i] != shape[i]) throw ShapeError({"indices are ", both});
      plan.nest.loops.push_back({indices[i], {steps[i], i < batch ? own[i] : 0}});
    }
    for (std::size_t i = batch; i < batch + size; ++i) {
      plan.strides.push_back(own[i]);
      plan.extents.push_back(shape[i]);
    }
    plan.block = size_of({shape.begin() + static_cast<std::ptrdiff_t>(batch + size), shape.end()});
    return plan.finished();
  }

 private:
  [[nodiscard]] IndexPlan finished() {
    nest.simplify();
    count = nest.size();
    return std::move(*this);
  }

  template <std::floating_point T>
  [[nodiscard]] std::ptrdiff_t offset(T index, std::size_t j) const {
    const std::size_t place = place_of_index(index, extents[j]);
    if (place == extents[j]) throw DomainError({"index ", index_text(index), " of ", extents[j]});
    return static_cast<std::ptrdiff_t>(place) * strides[j];
  }
};

/// Gather, GatherElements and GatherND: the blocks that indices select, one behind the other.
template <std::floating_point T>
class Gather : public Operation<T> {
 public:
  Gather(Shape shape, ElementType type, IndexPlan plan)
      : Operation<T>({{std::move(shape), type}}), plan_(std::move(plan)) {}

  void forward(const ForwardCall<T>& call) const override {
    call.state.choices.resize(plan_.count);
    const ElementIndex<T>* const places = call.state.choices.data();
    plan_.write_places(call.inputs[1].values, call.state.choices.data());
    const T* const from = call.inputs[0].values;
    T* const to = call.outputs[0].values;
    const std::size_t together =
        std::max<std::size_t>(detail::nest_block / std::max<std::size_t>(plan_.block, 1), 1);
    parallel_for_blocks(plan_.count, together, [&](std::size_t begin, std::size_t end) {
      for (std::size_t i = begin; i < end; ++i)
        std::memcpy(to + i * plan_.block, from + places[i], plan_.block * sizeof(T));
    });
  }

  void adjoint(const AdjointCall<T>& call) const override {
    T* const to = call.accumulate(0);
    const T* from = call.output_adjoints[0].values;
    const ElementIndex<T>* const places = call.state.choices.data();
    for (std::size_t i = 0; i < plan_.count; ++i)  // a block may be selected more than once
      for (std::size_t k = 0; k < plan_.block; ++k) to[static_cast<std::size_t>(places[i]) + k] += *from++;
  }

  [[nodiscard]] bool is_differentiable(std::size_t input) const override { return input == 0; }

 private:
  IndexPlan plan_;
};

namespace detail {
template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_gather(OperatorContext& context) {
  const Operand &x = context.input(0), &indices = context.input(1);
  context.require_type(1, ElementType::integer);
  const std::size_t axis = axis_of(context, x.shape, 0);
  const auto place = static_cast<std::ptrdiff_t>(axis);
  Shape shape(x.shape.begin(), x.shape.begin() + place);
  shape.insert(shape.end(), indices.shape.begin(), indices.shape.end());
  shape.insert(shape.end(), x.shape.begin() + place + 1, x.shape.end());
  return std::make_unique<Gather<T>>(shape, x.type,
                                     IndexPlan::of_axis(x.shape, axis, size_of(indices.shape)));
}

template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_gather_elements(OperatorContext& context) {
  const Operand &x = context.input(0), &indices = context.input(1);
  context.require_type(1, ElementType::integer);
  const std::size_t axis = axis_of(context, x.shape, 0);
  return std::make_unique<Gather<T>>(indices.shape, x.type,
                                     IndexPlan::of_elements(x.shape, axis, indices.shape));
}

template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_gather_nd(OperatorContext& context) {
  const Operand &x = context.input(0), &indices = context.input(1);
  context.require_type(1, ElementType::integer);
  const std::int64_t batch = context.integer("batch_dims", 0);
  const auto first = static_cast<std::size_t>(batch);
  IndexPlan plan = IndexPlan::of_tuples(x.shape, first, indices.shape);
  Shape shape(indices.shape.begin(), indices.shape.end() - 1);
  shape.insert(shape.end(), x.shape.begin() + static_cast<std::ptrdiff_t>(first + indices.shape.back()),
               x.shape.end());
  return std::make_unique<Gather<T>>(shape, x.type, std::move(plan));
}
}  // namespace detail

template <std::floating_point T>
void add_gather_operators(OperatorTable<T>& table) {
  table["Gather"] = {LayoutRule::plain, 1, false, {{2, 2}}, detail::make_gather<T>};
  table["GatherElements"] = {LayoutRule::plain, 1, false, {{2, 2}}, detail::make_gather_elements<T>};
  table["GatherND"] = {
      LayoutRule::plain, 1, false, {{2, 2}}, detail::make_gather_nd<T>, {{"batch_dims", 0, most_axes}}};
}
}  // namespace tapestry::nn

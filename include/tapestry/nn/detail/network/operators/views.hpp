#pragma once
#include <tapestry/nn/detail/network/operators/rearrange.hpp>
#include <tapestry/nn/detail/network/operators/reshape.hpp>

namespace tapestry::nn {
namespace detail {
/// Loops over a box, with the strides of both tensors along each axis.
[[nodiscard]] inline LoopNest<2> box_nest(const Shape& extents, const std::vector<std::ptrdiff_t>& from,
                                          const std::vector<std::ptrdiff_t>& to) {
  LoopNest<2> nest;
  for (std::size_t axis = 0; axis < extents.size(); ++axis)
    nest.loops.push_back({extents[axis], {from[axis], to[axis]}});
  return nest;
}

template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_transpose(OperatorContext& context) {
  const Operand& x = context.input(0);
  const std::size_t rank = x.shape.size();
  std::vector<std::int64_t> order(rank);
  for (std::size_t axis = 0; axis < rank; ++axis) order[axis] = static_cast<std::int64_t>(rank - 1 - axis);
  order = context.integers("perm", order);
  const auto own = strides_of(x.shape);
  Shape shape;
  std::vector<std::ptrdiff_t> from;
  for (const std::int64_t axis : order) {
    if (axis < 0 || static_cast<std::size_t>(axis) >= rank || std::ranges::count(order, axis) != 1)
      throw DomainError({"perm is not a permutation of the axes of ", x.shape});
    shape.push_back(x.shape[static_cast<std::size_t>(axis)]);
    from.push_back(own[static_cast<std::size_t>(axis)]);
  }
  if (shape.size() != rank) throw DomainError({"perm has ", shape.size(), " axes, expected ", rank});
  const Piece piece(0, 0, 0, 0, box_nest(shape, from, strides_of(shape)));
  return std::make_unique<Rearrange<T>>(std::vector<typename Operation<T>::Result>{{shape, x.type}},
                                        std::vector<Piece>{piece}, Coverage{});
}

struct AxisSlice {
  std::int64_t begin = 0, step = 1, count = 0;
  AxisSlice(std::int64_t extent, std::int64_t start, std::int64_t end, std::int64_t step_wanted)
      : step(step_wanted) {
    if (step == 0) throw DomainError("a step is 0");
    const auto place = [&](std::int64_t at, std::int64_t low, std::int64_t high) {
      return std::clamp(at < 0 ? at + extent : at, low, high);
    };
    begin = step > 0 ? place(start, 0, extent) : place(start, 0, extent - 1);
    const std::int64_t last = step > 0 ? place(end, 0, extent) : place(end, -1, extent - 1);
    const std::int64_t length = step > 0 ? last - begin : begin - last;
    const std::int64_t size = step > 0 ? step : -step;
    count = length > 0 && extent > 0 ? (length - 1) / size + 1 : 0;
  }
};

template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_slice(OperatorContext& context) {
  const bool has_operands = context.opset() >= 10;
  const Operand& x = context.input(0);
  const auto starts = has_operands ? context.integers(1) : context.integers("starts");
  const auto ends = has_operands ? context.integers(2) : context.integers("ends");
  std::vector<std::int64_t> axes(starts.size()), steps(starts.size(), 1);
  for (std::size_t i = 0; i < axes.size(); ++i) axes[i] = static_cast<std::int64_t>(i);
  if (!has_operands) {
    axes = context.integers("axes", axes);
  } else {
    if (context.has_input(3)) axes = context.integers(3);
    if (context.has_input(4)) steps = context.integers(4);
  }
  if (ends.size() != starts.size() || axes.size() != starts.size() || steps.size() != starts.size())
    throw ShapeError("starts, ends, axes and steps are not of one size");
  Shape shape = x.shape;
  auto strides = strides_of(x.shape);
  std::ptrdiff_t first = 0;
  std::vector<bool> is_sliced(shape.size(), false);
  for (std::size_t i = 0; i < starts.size(); ++i) {
    const std::size_t axis = context.axis(axes[i], shape.size());
    if (axis >= shape.size() || is_sliced[axis]) throw DomainError({"axis ", axes[i], " is named twice"});
    is_sliced[axis] = true;
    const AxisSlice slice(static_cast<std::int64_t>(shape[axis]), starts[i], ends[i], steps[i]);
    first += slice.begin * strides[axis];
    if (slice.count > 1) strides[axis] *= slice.step;
    shape[axis] = static_cast<std::size_t>(slice.count);
  }
  const Piece piece(0, 0, size_of(shape) == 0 ? 0 : first, 0, box_nest(shape, strides, strides_of(shape)));
  return std::make_unique<Rearrange<T>>(std::vector<typename Operation<T>::Result>{{shape, x.type}},
                                        std::vector<Piece>{piece}, Coverage{shape == x.shape, true});
}

template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_concat(OperatorContext& context) {
  Shape shape = context.input(0).shape;
  const std::size_t axis = context.axis(context.integer("axis", 0), shape.size());
  if (!context.has_attribute("axis")) throw DomainError("attribute 'axis' is missing");
  if (axis >= shape.size()) throw ShapeError("scalars cannot be joined");
  shape[axis] = 0;
  for (std::size_t i = 0; i < context.inputs.size(); ++i) {
    const Shape& part = context.input(i).shape;
    Shape common = part;
    if (part.size() == shape.size()) common[axis] = shape[axis];
    if (common != shape)
      throw ShapeError({"operand ", i, " is ", part, ", which cannot be joined to ", context.input(0).shape});
    shape[axis] += part[axis];
  }
  std::vector<Piece> pieces;
  const auto to = strides_of(shape);
  std::ptrdiff_t begin = 0;
  for (std::size_t i = 0; i < context.inputs.size(); ++i) {
    const Shape& part = context.input(i).shape;
    pieces.emplace_back(i, 0, 0, begin * to[axis], box_nest(part, strides_of(part), to));
    begin += static_cast<std::ptrdiff_t>(part[axis]);
  }
  auto joined = std::make_unique<Rearrange<T>>(
      std::vector<typename Operation<T>::Result>{{shape, context.input(0).type}}, std::move(pieces),
      Coverage{}, context.inputs.size());
  if (context.channels_last() && axis == 3) joined->set_pixelwise();
  return joined;
}

/// Extents of Split's results along the axis.
[[nodiscard]] inline std::vector<std::int64_t> split_extents(OperatorContext& context, std::size_t extent) {
  const bool has_operand = context.opset() >= 13;
  const auto wanted = static_cast<std::int64_t>(context.output_count());
  const std::int64_t count = context.opset() >= 18 ? context.integer("num_outputs", wanted) : wanted;
  if (has_operand && context.has_input(1)) return context.integers(1);
  if (!has_operand && context.has_attribute("split")) return context.integers("split");
  const auto whole = static_cast<std::int64_t>(extent);
  if (count < 1 || count > wanted)
    throw DomainError({"num_outputs is ", count, " of a node with ", wanted, " results"});
  if (context.opset() < 18 && whole % count != 0)
    throw ShapeError({whole, " cannot be split into ", count, " equal parts"});
  const std::int64_t part = (whole + count - 1) / count;
  std::vector<std::int64_t> extents;
  for (std::int64_t i = 0; i < count; ++i)
    extents.push_back(std::max<std::int64_t>(std::min(part, whole - i * part), 0));
  return extents;
}

template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_split(OperatorContext& context) {
  const Operand& x = context.input(0);
  const std::size_t axis = context.axis(context.integer("axis", 0), x.shape.size());
  if (axis >= x.shape.size()) throw ShapeError("a scalar cannot be split");
  const auto extents = split_extents(context, x.shape[axis]);
  const auto from = strides_of(x.shape);
  std::vector<typename Operation<T>::Result> results;
  std::vector<Piece> pieces;
  std::size_t begin = 0;
  for (const std::int64_t extent : extents) {
    Shape shape = x.shape;
    shape[axis] = to_extent(extent);
    pieces.emplace_back(0, results.size(), static_cast<std::ptrdiff_t>(begin) * from[axis], 0,
                        box_nest(shape, from, strides_of(shape)));
    begin += shape[axis];
    results.push_back({std::move(shape), x.type});
  }
  if (begin != x.shape[axis]) throw ShapeError({"the parts have ", begin, " of ", x.shape[axis]});
  auto parts = std::make_unique<Rearrange<T>>(std::move(results), std::move(pieces), Coverage{});
  if (context.channels_last() && axis == 3) parts->set_pixelwise();
  return parts;
}

/// Reorders settings of the axes N, C, H and W to the storage order channels last.
template <class Value>
[[nodiscard]] std::vector<Value> in_stored_order(const std::vector<Value>& logical) {
  std::vector<Value> stored(4);
  for (std::size_t axis = 0; axis < 4; ++axis) stored[stored_axis[axis]] = logical[axis];
  return stored;
}

/// Operand 1 has the extents to repeat operand 0 to.
template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_expand(OperatorContext& context) {
  const Operand& x = context.input(0);
  const bool is_last = context.channels_last() && x.shape.size() == 4;
  Shape own = x.shape, wanted;
  auto own_strides = strides_of(x.shape);
  for (std::size_t axis = 0; axis < 4 && is_last; ++axis) {
    own[axis] = x.shape[stored_axis[axis]];
    own_strides[axis] = strides_of(x.shape)[stored_axis[axis]];
  }
  for (const std::int64_t extent : context.integers(1)) wanted.push_back(to_extent(extent));
  Shape shape = broadcast_shape(own, wanted);
  std::vector<std::ptrdiff_t> strides(shape.size(), 0);
  for (std::size_t i = 1; i <= own.size(); ++i)
    if (own[own.size() - i] != 1) strides[shape.size() - i] = own_strides[own.size() - i];
  if (is_last && shape.size() == 4) {
    shape = in_stored_order(shape);
    strides = in_stored_order(strides);
  }
  return std::make_unique<Repeat<T>>(shape, x.type, shape, strides);
}

template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_tile(OperatorContext& context) {
  const Operand& x = context.input(0);
  const auto repeats = context.integers(1);
  if (repeats.size() != x.shape.size())
    throw ShapeError({"repeats has ", repeats.size(), " elements, expected ", x.shape.size()});
  Shape shape = x.shape, extents;
  std::vector<std::ptrdiff_t> strides;
  std::vector<std::size_t> times(repeats.size());
  for (std::size_t i = 0; i < repeats.size(); ++i)
    times[context.axis(static_cast<std::int64_t>(i), repeats.size())] = to_extent(repeats[i]);
  const auto own = strides_of(x.shape);
  for (std::size_t axis = 0; axis < times.size(); ++axis) {
    shape[axis] *= times[axis];
    extents.insert(extents.end(), {times[axis], x.shape[axis]});
    strides.insert(strides.end(), {0, own[axis]});
  }
  return std::make_unique<Repeat<T>>(shape, x.type, extents, strides);
}
}  // namespace detail

/// Operators that take, join, reverse and repeat boxes of elements.
template <std::floating_point T>
void add_view_operators(OperatorTable<T>& table) {
  table["Transpose"] = {LayoutRule::plain, 1, false, {{1, 1}}, detail::make_transpose<T>};
  table["Slice"] = {LayoutRule::any, 1, false, {{1, 1}, {3, 5, 10}}, detail::make_slice<T>};
  table["Concat"] = {LayoutRule::any, all_inputs, false, {{1, all_inputs}}, detail::make_concat<T>};
  table["Split"] = {LayoutRule::any, 1, false, {{1, 1}, {1, 2, 13}}, detail::make_split<T>};
  table["Expand"] = {LayoutRule::any, 1, false, {{2, 2}}, detail::make_expand<T>};
  table["Tile"] = {LayoutRule::any, 1, false, {{2, 2}}, detail::make_tile<T>};
}
}  // namespace tapestry::nn

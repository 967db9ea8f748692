#pragma once
#include <tapestry/nn/detail/network/operators/pass_on.hpp>

namespace tapestry::nn {
namespace detail {
/// An extent that a node states. \throws DomainError outside 0 … 2^31 − 1
[[nodiscard]] inline std::size_t to_extent(std::int64_t value) {
  if (value < 0 || value > largest_extent)
    throw DomainError({"extent ", value, ", expected 0 to 2147483647"});
  return static_cast<std::size_t>(value);
}

/// Axes of an attribute or, from opset `since` on, of an operand, as places in `rank` axes; none if the node
/// names none.
/// \throws DomainError if one is named twice
[[nodiscard]] inline std::optional<std::vector<std::size_t>> axes_of(OperatorContext& context,
                                                                     std::int64_t since, std::size_t rank) {
  const bool is_operand = context.opset() >= since;
  if (!(is_operand ? context.has_input(1) : context.has_attribute("axes"))) return std::nullopt;
  std::vector<std::size_t> places;
  for (const std::int64_t axis : is_operand ? context.integers(1) : context.integers("axes")) {
    const std::size_t place = context.axis(axis, rank);
    if (place >= rank) throw ShapeError("a scalar has no axes");
    if (std::ranges::count(places, place) != 0) throw DomainError({"axis ", axis, " is named twice"});
    places.push_back(place);
  }
  return places;
}

/// The axis that a node states, of an operand that has any.
[[nodiscard]] inline std::size_t axis_of(OperatorContext& context, const Shape& shape,
                                         std::int64_t otherwise) {
  if (shape.empty()) throw ShapeError("a scalar has no axes");
  return context.axis(context.integer("axis", otherwise), shape.size());
}

/// Extents of Reshape's result. 0 stands for the operand's extent unless allowzero is set; one −1 stands for
/// the remaining elements.
[[nodiscard]] inline Shape reshaped(const Shape& from, const std::vector<std::int64_t>& wanted,
                                    bool allows_zero) {
  Shape shape;
  std::optional<std::size_t> open;
  for (std::size_t axis = 0; axis < wanted.size(); ++axis) {
    if (wanted[axis] == -1 && !open) {
      open = axis;
      shape.push_back(1);
      continue;
    }
    const bool is_kept = wanted[axis] == 0 && !allows_zero;
    if (is_kept && axis >= from.size()) throw ShapeError({"extent 0 at axis ", axis, " of ", from});
    shape.push_back(is_kept ? from[axis] : to_extent(wanted[axis]));
  }
  require_room(shape);
  if (const std::size_t known = size_of(shape); open && known != 0) shape[*open] = size_of(from) / known;
  if (size_of(shape) != size_of(from))
    throw ShapeError({from, " cannot become ", tapestry::detail::to_text(wanted)});
  return shape;
}

template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_reshape(OperatorContext& context) {
  const bool allows_zero = context.flag("allowzero", 0);
  const Operand& x = context.input(0);
  return std::make_unique<PassOn<T>>(reshaped(x.shape, context.integers(1), allows_zero), x.type);
}

template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_flatten(OperatorContext& context) {
  const Operand& x = context.input(0);
  const auto rank = static_cast<std::int64_t>(x.shape.size());
  std::int64_t axis = context.integer("axis", 1);
  if (axis < -rank || axis > rank) throw DomainError({"axis ", axis, " of ", rank, " axes"});
  if (axis < 0) axis += rank;
  const auto middle = x.shape.begin() + axis;
  const Shape shape = {size_of({x.shape.begin(), middle}), size_of({middle, x.shape.end()})};
  return std::make_unique<PassOn<T>>(shape, x.type);
}

template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_squeeze(OperatorContext& context) {
  const Operand& x = context.input(0);
  const auto axes = axes_of(context, 13, x.shape.size());
  Shape shape;
  for (std::size_t axis = 0; axis < x.shape.size(); ++axis) {
    const bool is_named = axes && std::ranges::count(*axes, axis) != 0;
    if (is_named && x.shape[axis] != 1)
      throw ShapeError({"axis ", axis, " of ", x.shape, " cannot be left out"});
    if (is_named || (!axes && x.shape[axis] == 1)) continue;
    shape.push_back(x.shape[axis]);
  }
  return std::make_unique<PassOn<T>>(shape, x.type);
}

template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_unsqueeze(OperatorContext& context) {
  const Operand& x = context.input(0);
  const std::size_t count =
      context.opset() >= 13 ? context.integers(1).size() : context.integers("axes").size();
  const auto axes = axes_of(context, 13, x.shape.size() + count);
  if (!axes) throw DomainError("there are no axes");
  Shape shape;
  auto next = x.shape.begin();
  for (std::size_t axis = 0; axis < x.shape.size() + count; ++axis)
    shape.push_back(std::ranges::count(*axes, axis) != 0 ? 1 : *next++);
  return std::make_unique<PassOn<T>>(shape, x.type);
}
}  // namespace detail

/// Operators that keep the values and their order, and change the axes.
template <std::floating_point T>
void add_reshape_operators(OperatorTable<T>& table) {
  table["Reshape"] = {LayoutRule::plain, 1, false, {{2, 2}}, detail::make_reshape<T>};
  table["Flatten"] = {LayoutRule::plain, 1, false, {{1, 1}}, detail::make_flatten<T>};
  table["Squeeze"] = {LayoutRule::plain, 1, false, {{1, 1}, {1, 2, 13}}, detail::make_squeeze<T>};
  table["Unsqueeze"] = {LayoutRule::plain, 1, false, {{1, 1}, {2, 2, 13}}, detail::make_unsqueeze<T>};
}
}  // namespace tapestry::nn

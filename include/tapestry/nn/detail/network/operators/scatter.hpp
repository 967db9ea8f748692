#pragma once
#include <tapestry/nn/detail/network/operators/gather.hpp>

namespace tapestry::nn {
/// How an update changes its element.
enum class ScatterRule { replace, add, multiply, largest, smallest };

/// ScatterND and ScatterElements: a copy of a tensor; updates are applied to the blocks that indices select,
/// one after another. If an update equals its element, the element gets the adjoint.
template <std::floating_point T>
class Scatter : public Operation<T> {
 public:
  Scatter(const Operand& x, IndexPlan plan, ScatterRule rule)
      : Operation<T>({{x.shape, x.type}}), plan_(std::move(plan)), rule_(rule) {}

  void forward(const ForwardCall<T>& call) const override {
    T* const to = call.outputs[0].values;
    if (call.inputs[0].values != to) copy(call.inputs[0].values, to, call.outputs[0].size());
    call.state.choices.resize(plan_.count);
    plan_.write_places(call.inputs[1].values, call.state.choices.data());
    const bool remembers = call.keeps && needs_values();
    if (remembers) call.state.values.resize(plan_.count * plan_.block);
    const T* update = call.inputs[2].values;
    std::size_t next = 0;
    for (std::size_t i = 0; i < plan_.count; ++i) {
      T* const block = to + call.state.choices.data()[i];
      for (std::size_t k = 0; k < plan_.block; ++k, ++update) {
        if (remembers) call.state.values.data()[next++] = block[k];
        block[k] = updated(block[k], *update);
      }
    }
  }

  /// Goes through the updates backwards; dy becomes the adjoint of the tensor before each.
  void adjoint(const AdjointCall<T>& call) const override {
    T* const dy = call.output_adjoints[0].values;
    T* const updates = call.wants(2) ? call.accumulate(2) : nullptr;
    for (std::size_t i = plan_.count; i-- > 0;) {
      T* const block = dy + call.state.choices.data()[i];
      for (std::size_t k = 0; k < plan_.block; ++k) {
        const std::size_t place = i * plan_.block + k;
        const T before = needs_values() ? call.state.values.data()[place] : T(0);
        const T update = needs_values() ? call.inputs[2].values[place] : T(0);
        const auto [by_element, by_update] = slopes(before, update);
        if (updates != nullptr) updates[place] += by_update * block[k];
        block[k] *= by_element;
      }
    }
    if (call.wants(0)) BroadcastOperand().pull_back(dy, T(1), call, 0);
  }

  [[nodiscard]] AdjointReads adjoint_reads() const override { return {needs_values() ? 4U : 0U, 0}; }
  [[nodiscard]] bool is_differentiable(std::size_t input) const override { return input != 1; }
  [[nodiscard]] bool works_in_place() const override { return true; }

 private:
  [[nodiscard]] bool needs_values() const {
    return rule_ != ScatterRule::replace && rule_ != ScatterRule::add;
  }
  [[nodiscard]] T updated(T element, T update) const {
    if (rule_ == ScatterRule::add) return element + update;
    if (rule_ == ScatterRule::multiply) return element * update;
    if (rule_ == ScatterRule::largest) return update > element || update != update ? update : element;
    if (rule_ == ScatterRule::smallest) return update < element || update != update ? update : element;
    return update;
  }
  /// Derivatives of updated().
  [[nodiscard]] std::pair<T, T> slopes(T element, T update) const {
    const std::pair<T, T> of_element{1, 0}, of_update{0, 1};
    if (rule_ == ScatterRule::add) return {1, 1};
    if (rule_ == ScatterRule::multiply) return {update, element};
    if (rule_ == ScatterRule::largest) return update > element ? of_update : of_element;
    if (rule_ == ScatterRule::smallest) return update < element ? of_update : of_element;
    return of_update;
  }

  IndexPlan plan_;
  ScatterRule rule_;
};

namespace detail {
[[nodiscard]] inline ScatterRule scatter_rule(OperatorContext& context) {
  const std::string name = context.text("reduction", "none");
  const char* const names[] = {"none", "add", "mul", "max", "min"};
  for (int rule = 0; rule < 5; ++rule)
    if (name == names[rule]) return static_cast<ScatterRule>(rule);
  throw DomainError({"reduction is ", in_quotes(name), ", expected 'none', 'add', 'mul', 'max' or 'min'"});
}

/// \throws ShapeError unless the updates are of the extents expected
inline void require_updates(const OperatorContext& context, const Shape& expected) {
  if (context.input(2).shape != expected)
    throw ShapeError({"updates are ", context.input(2).shape, ", expected ", expected});
}

template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_scatter_nd(OperatorContext& context) {
  const Operand &x = context.input(0), &indices = context.input(1);
  context.require_type(1, ElementType::integer);
  IndexPlan plan = IndexPlan::of_tuples(x.shape, 0, indices.shape);
  Shape expected(indices.shape.begin(), indices.shape.end() - 1);
  expected.insert(expected.end(), x.shape.begin() + static_cast<std::ptrdiff_t>(indices.shape.back()),
                  x.shape.end());
  require_updates(context, expected);
  return std::make_unique<Scatter<T>>(x, std::move(plan), scatter_rule(context));
}

template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_scatter_elements(OperatorContext& context) {
  const Operand &x = context.input(0), &indices = context.input(1);
  context.require_type(1, ElementType::integer);
  const std::size_t axis = axis_of(context, x.shape, 0);
  IndexPlan plan = IndexPlan::of_elements(x.shape, axis, indices.shape);
  require_updates(context, indices.shape);
  return std::make_unique<Scatter<T>>(x, std::move(plan), scatter_rule(context));
}
}  // namespace detail

template <std::floating_point T>
void add_scatter_operators(OperatorTable<T>& table) {
  table["ScatterND"] = {LayoutRule::plain, 1, false, {{3, 3}}, detail::make_scatter_nd<T>};
  table["ScatterElements"] = {LayoutRule::plain, 1, false, {{3, 3}}, detail::make_scatter_elements<T>};
  table["Scatter"] = table["ScatterElements"];  // up to opset 10
}
}  // namespace tapestry::nn

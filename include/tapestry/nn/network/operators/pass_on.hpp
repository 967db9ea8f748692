#pragma once
#include <concepts>
#include <memory>
#include <tapestry/nn/network/operator_table.hpp>
#include <tapestry/nn/pointwise.hpp>
#include <utility>
#include <vector>

namespace tapestry::nn {

/// A tensor's values in the same order, under whatever extents: Identity, Reshape and their like.
template <std::floating_point T>
class PassOn : public Operation<T> {
 public:
  PassOn(Shape shape, ElementType type) : Operation<T>({{std::move(shape), type}}) {}

  void forward(const ForwardCall<T>& call) const override {
    if (call.inputs[0].values != call.outputs[0].values)
      copy(call.inputs[0].values, call.outputs[0].values, call.outputs[0].size());
  }

  void adjoint(const AdjointCall<T>& call) const override {
    const std::size_t count = call.output_adjoints[0].size();
    if (call.is_fresh[0]) {
      copy(call.output_adjoints[0].values, call.input_adjoints[0].values, count);
      call.is_fresh[0] = false;
    } else {
      add(call.output_adjoints[0].values, call.input_adjoints[0].values, count);
    }
  }

  [[nodiscard]] bool is_differentiable(std::size_t input) const override { return input == 0; }
  [[nodiscard]] bool works_in_place() const override { return true; }
};

/// Identity, and Dropout outside of training.
template <std::floating_point T>
void add_pass_on(OperatorTable<T>& table) {
  const auto identity = [](OperatorContext& context) {
    for (const char* setting : {"ratio", "seed", "is_test"}) context.ignore(setting);
    return std::make_unique<PassOn<T>>(context.input(0).shape, context.input(0).type);
  };
  table["Identity"] = {LayoutRule::any, 1, false, identity};
  table["Dropout"] = {LayoutRule::any, 1, false, identity};
}

}  // namespace tapestry::nn

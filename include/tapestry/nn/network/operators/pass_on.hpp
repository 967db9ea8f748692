#pragma once
#include <algorithm>
#include <concepts>
#include <cstdint>
#include <memory>
#include <tapestry/nn/network/operator_table.hpp>
#include <tapestry/nn/network/operators/window_attributes.hpp>
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

 protected:
  explicit PassOn(std::vector<typename Operation<T>::Result> results) : Operation<T>(std::move(results)) {}
};

/// Dropout outside of training, which drops nothing; result 1 says so of each element.
template <std::floating_point T>
class Dropout : public PassOn<T> {
 public:
  explicit Dropout(const Operand& x) : PassOn<T>({{x.shape, x.type}, {x.shape, ElementType::boolean}}) {}

  void forward(const ForwardCall<T>& call) const override {
    PassOn<T>::forward(call);
    if (call.outputs.size() > 1) std::fill_n(call.outputs[1].values, call.outputs[1].size(), T(1));
  }
};

namespace detail {
template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_dropout(OperatorContext& context) {
  for (const char* setting : {"ratio", "seed", "is_test"}) context.ignore(setting);
  const bool is_training =
      context.has_input(2) && (context.constant(2).size() != 1 || context.constant(2).at(0) != 0);
  const bool drops =
      !context.has_input(1) || context.constant(1).size() != 1 || context.constant(1).at(0) != 0;
  if (is_training && drops) throw DomainError("training_mode is true; only false is supported");
  return std::make_unique<Dropout<T>>(context.input(0));
}
}  // namespace detail

/// Identity and Dropout; and FlattenPixels, which simplified() makes of Reshape and Transpose: a picture
/// [N, C, H, W] as [N, H · W, C].
template <std::floating_point T>
void add_pass_on(OperatorTable<T>& table) {
  const auto identity = [](OperatorContext& context) {
    return std::make_unique<PassOn<T>>(context.input(0).shape, context.input(0).type);
  };
  table["Identity"] = {LayoutRule::any, 1, false, identity};
  table["FlattenPixels"] = {LayoutRule::channels_last, 1, false, [](OperatorContext& context) {
                              const Shape& shape = picture_shape(context);
                              return std::make_unique<PassOn<T>>(
                                  Shape{shape[0], shape[1] * shape[2], shape[3]}, context.input(0).type);
                            }};
  table["Dropout"] = {LayoutRule::any, 1, false, detail::make_dropout<T>};
}

}  // namespace tapestry::nn

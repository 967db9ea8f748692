#pragma once
#include <tapestry/nn/detail/network/operators/pooling.hpp>
#include <tapestry/nn/detail/network/operators/reduce.hpp>

/// \file
/// The operators Tangent and TangentPool, see tangent_network.hpp: those of the attribute `of`, together with
/// the derivative along a direction. Operands (x, ẋ, the operator's further ones), results (y, ẏ).

namespace tapestry::nn {
/// A function of each element, and its derivative along ẋ:
///
///   ẏ = f'(x)·ẋ    x̄ += f'(x)·ȳ + f''(x)·ẋ·ẏ̄    ẋ̄ += f'(x)·ẏ̄
template <std::floating_point T>
class UnaryTangent : public UnaryOperation<T> {
 public:
  UnaryTangent(const UnaryOperation<T>& function, const Operand& x)
      : UnaryOperation<T>(function, {{x.shape, x.type}, {x.shape, x.type}}) {}

  void forward(const ForwardCall<T>& call) const override {
    const T *const x = call.inputs[0].values, *const u = call.inputs[1].values;
    T *const y = call.outputs[0].values, *const v = call.outputs[1].values;
    detail::for_each_block(call.outputs[0].size(), [&](std::size_t i, std::size_t count) {
      this->loops_.with_tangent(x + i, u + i, y + i, v + i, count, this->a_, this->b_);
    });
  }

  void adjoint(const AdjointCall<T>& call) const override {
    const T* const kept =
        this->loops_.reads == unary::Reads::output ? call.outputs[0].values : call.inputs[0].values;
    const T* const u = call.inputs[1].values;
    const std::size_t size = call.outputs[0].size();
    T *from[2], *to[2];
    bool adds[2];
    Buffer<T> zeros[2];
    for (std::size_t i = 0; i < 2; ++i) {
      from[i] = call.output_adjoints[i].values;
      if (from[i] == nullptr) {
        zeros[i].resize(size);
        zeros[i].fill_zero();
        from[i] = zeros[i].data();
      }
      const bool writes = call.wants(i) && call.is_uninitialised[i];
      adds[i] = call.wants(i) && !writes;
      to[i] = writes ? call.input_adjoints[i].values : from[i];
      call.is_uninitialised[i] = false;
    }
    detail::for_each_block(size, [&](std::size_t k, std::size_t count) {
      this->loops_.tangent_adjoint(kept + k, u + k, from[0] + k, from[1] + k, to[0] + k, to[1] + k, count,
                                   this->a_, this->b_);
      for (std::size_t i = 0; i < 2; ++i)
        if (adds[i]) kernels<T>().add(to[i] + k, call.input_adjoints[i].values + k, count);
    });
  }

  [[nodiscard]] AdjointReads adjoint_reads() const override {
    return this->loops_.reads == unary::Reads::output ? AdjointReads{2, 1} : AdjointReads{3, 0};
  }
  [[nodiscard]] bool is_differentiable(std::size_t input) const override { return input < 2; }
  [[nodiscard]] bool works_in_place() const override { return false; }
};

/// An operation that chooses elements of x, or scales them by signs, with the same choice of ẋ.
template <std::floating_point T>
class ChoiceTangent : public Operation<T> {
 public:
  explicit ChoiceTangent(std::unique_ptr<Operation<T>> choice)
      : Operation<T>({choice->results()[0], choice->results()[0]}), choice_(std::move(choice)) {}

  void forward(const ForwardCall<T>& call) const override {
    const TensorView<const T> inputs[] = {call.inputs[0]};
    choice_->forward({inputs, call.outputs.first(1), call.state, true, call.engine});
    choice_->apply_choice(call.state, call.inputs[1].values, call.outputs[1].values);
  }

  void adjoint(const AdjointCall<T>& call) const override {
    for (std::size_t i = 0; i < 2; ++i) {
      if (!call.wants(i)) continue;
      if (!call.output_adjoints[i].is_there()) {
        static_cast<void>(call.accumulate(i));
        continue;
      }
      choice_->adjoint({call.inputs.subspan(i, 1), call.outputs.subspan(i, 1),
                        call.output_adjoints.subspan(i, 1), call.input_adjoints.subspan(i, 1),
                        call.is_uninitialised.subspan(i, 1), call.state, call.engine});
    }
  }
  [[nodiscard]] bool is_differentiable(std::size_t input) const override { return input < 2; }

 private:
  std::unique_ptr<Operation<T>> choice_;
};

namespace detail {
template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_tangent(OperatorContext& context) {
  Node node = context.node();
  node.operation = context.text("of", "");
  node.attributes.erase("of");
  for (const auto& [name, value] : node.attributes) context.ignore(name);
  const Operand x = context.input(0);
  if (context.input(1).shape != x.shape)
    throw ShapeError({"the tangent is ", context.input(1).shape, ", expected ", x.shape});
  const auto found = operators<T>().find(node.operation);
  if (found == operators<T>().end()) throw DomainError({"no operator ", in_quotes(node.operation)});
  auto operands = context.inputs;
  operands.erase(operands.begin() + 1);
  OperatorContext own(node, context.opset(), std::move(operands), context.channels_last());
  auto operation = made_operation(found->second, own);
  if (const auto* const unary = dynamic_cast<const UnaryOperation<T>*>(operation.get());
      unary != nullptr && unary->has_tangent())
    return std::make_unique<UnaryTangent<T>>(*unary, x);
  static const std::set<std::string> choices{"GlobalMaxPool", "LeakyRelu", "MaxPool",
                                             "ReduceMax",     "ReduceMin", "Relu"};
  if (!choices.contains(node.operation))
    throw DomainError({"operator ", in_quotes(node.operation), " is no function of one number"});
  return std::make_unique<ChoiceTangent<T>>(std::move(operation));
}
}  // namespace detail

/// Adds Tangent and TangentPool.
template <std::floating_point T>
void add_tangent(OperatorTable<T>& table) {
  table["Tangent"] = {LayoutRule::any, 2, false, {{2, 4}}, detail::make_tangent<T>};
  table["TangentPool"] = {LayoutRule::channels_last, 2, false, {{2, 2}}, detail::make_tangent<T>};
}
}  // namespace tapestry::nn

#pragma once
#include <tapestry/nn/detail/network/broadcast.hpp>
#include <tapestry/nn/detail/network/operators/kernel_attributes.hpp>
#include <tapestry/nn/detail/network/operators/unary.hpp>

namespace tapestry::nn {
/// A tensor's values in the same order with new extents: Identity, Reshape and the like.
template <std::floating_point T>
class PassOn : public Operation<T> {
 public:
  PassOn(Shape shape, ElementType type) : Operation<T>({{std::move(shape), type}}) {}

  void forward(const ForwardCall<T>& call) const override {
    if (call.inputs[0].values != call.outputs[0].values)
      copy(call.inputs[0].values, call.outputs[0].values, call.outputs[0].size());
  }

  void adjoint(const AdjointCall<T>& call) const override {
    BroadcastOperand().pull_back(call.output_adjoints[0].values, T(1), call, 0);
  }

  [[nodiscard]] bool is_differentiable(std::size_t input) const override { return input == 0; }
  [[nodiscard]] bool works_in_place() const override { return true; }

 protected:
  explicit PassOn(std::vector<typename Operation<T>::Result> results) : Operation<T>(std::move(results)) {}
};

/// Dropout outside of training, an identity; result 1 is true for each element.
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

/// Meaning of the elements of one of ONNX's types. Source: onnx.proto, TensorProto.DataType.
/// \throws DomainError for texts, complex numbers and those of 8 bits
[[nodiscard]] inline ElementType meaning_of(std::int64_t type) {
  if (type == 1 || type == 10 || type == 11 || type == 16) return ElementType::floating;
  if ((type >= 2 && type <= 7) || type == 12 || type == 13) return ElementType::integer;
  if (type == 9) return ElementType::boolean;
  throw DomainError({"element type ", type, " is not supported"});
}

template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_cast(const Operand& x, ElementType type) {
  if (type == ElementType::boolean && x.type != type)
    return std::make_unique<UnaryOperation<T>>(x, type, unary_loops<unary::IsTrue<T>, T>(), T(0), T(0));
  if (type == ElementType::integer && x.type == ElementType::floating)
    return std::make_unique<UnaryOperation<T>>(x, type, unary_loops<unary::Truncate<T>, T>(), T(0), T(0));
  return std::make_unique<PassOn<T>>(x.shape, type);
}
}  // namespace detail

/// Identity and Dropout; and FlattenPixels, which simplified() makes of Reshape and Transpose: a picture
/// [N, C, H, W] as [N, H · W, C].
template <std::floating_point T>
void add_pass_on(OperatorTable<T>& table) {
  const auto identity = [](OperatorContext& context) {
    return std::make_unique<PassOn<T>>(context.input(0).shape, context.input(0).type);
  };
  table["Identity"] = {LayoutRule::any, 1, false, {{1, 1}}, identity};
  table["FlattenPixels"] = {LayoutRule::channels_last, 1, false, {{1, 1}}, [](OperatorContext& context) {
                              const Shape& shape = picture_shape(context);
                              return std::make_unique<PassOn<T>>(
                                  Shape{shape[0], shape[1] * shape[2], shape[3]}, context.input(0).type);
                            }};
  table["Dropout"] = {LayoutRule::any, 1, false, {{1, 1}, {1, 3, 12}}, detail::make_dropout<T>};
}

/// Cast and CastLike. Everything is computed in one type, so casts round no digits and clip no integers.
/// Casts to integers cut fractions off.
template <std::floating_point T>
void add_cast_operators(OperatorTable<T>& table) {
  const auto cast = [](OperatorContext& context) {
    context.ignore("saturate");
    return detail::make_cast<T>(context.input(0), detail::meaning_of(context.integer("to", 0)));
  };
  const auto cast_like = [](OperatorContext& context) {
    context.ignore("saturate");
    return detail::make_cast<T>(context.input(0), context.input(1).type);
  };
  table["Cast"] = {LayoutRule::any, 1, false, {{1, 1}}, cast};
  table["CastLike"] = {LayoutRule::any, 1, false, {{2, 2}}, cast_like};
}
}  // namespace tapestry::nn

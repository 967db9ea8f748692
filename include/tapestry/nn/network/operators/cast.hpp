#pragma once
#include <concepts>
#include <cstdint>
#include <memory>
#include <string>
#include <tapestry/nn/network/operator_table.hpp>
#include <tapestry/nn/network/operators/pass_on.hpp>
#include <tapestry/nn/network/operators/unary.hpp>

namespace tapestry::nn {
namespace detail {

/// What the elements of one of ONNX's types mean. Source: onnx.proto, TensorProto.DataType.
/// \throws DomainError for texts, complex numbers and those of 8 bits
[[nodiscard]] inline ElementType meaning_of(std::int64_t type) {
  if (type == 1 || type == 10 || type == 11 || type == 16) return ElementType::floating;
  if ((type >= 2 && type <= 7) || type == 12 || type == 13) return ElementType::integer;
  if (type == 9) return ElementType::boolean;
  throw DomainError("element type " + std::to_string(type) + " is not supported");
}

template <std::floating_point T>
[[nodiscard]] std::unique_ptr<Operation<T>> make_cast(const Operand& x, ElementType type) {
  if (type == ElementType::boolean && x.type != type)
    return std::make_unique<UnaryOperation<T>>(x, type, unary_loops<unary::IsTrue, T>(), T(0), T(0));
  if (type == ElementType::integer && x.type == ElementType::floating)
    return std::make_unique<UnaryOperation<T>>(x, type, unary_loops<unary::Truncate, T>(), T(0), T(0));
  return std::make_unique<PassOn<T>>(x.shape, type);
}
}  // namespace detail

/// Cast and CastLike. All is computed in one type, so that numbers are not rounded to a smaller type's
/// digits, nor integers cut to its range; fractions are cut off where integers are wanted.
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
  table["Cast"] = {LayoutRule::any, 1, false, cast};
  table["CastLike"] = {LayoutRule::any, 1, false, cast_like};
}

}  // namespace tapestry::nn

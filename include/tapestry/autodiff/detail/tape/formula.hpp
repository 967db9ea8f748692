#pragma once
#include <tapestry/autodiff/detail/tape/numeric_limits.hpp>

namespace tapestry::detail {
/// Two operands that make a formula: both expressions, or one of them and a constant.
template <class X, class Y>
concept ExpressionOperands = (ScalarExpression<X> && ScalarExpression<Y>) ||
                             (ScalarExpression<X> &&
                              ConstantOf<Y, typename std::remove_cvref_t<X>::ExpressionScalar>) ||
                             (ScalarExpression<Y> &&
                              ConstantOf<X, typename std::remove_cvref_t<Y>::ExpressionScalar>);

/// Two operands: a Dual, and the same Dual type or a constant.
template <class X, class Y>
concept DualOperands = (DualNumber<X> &&
                        (std::same_as<X, Y> || std::convertible_to<Y, typename X::value_type>)) ||
                       (DualNumber<Y> && std::convertible_to<X, typename Y::value_type>);

template <class X, class Y>
concept FormulaOperands = ExpressionOperands<X, Y> || DualOperands<X, Y>;

template <class X, class Y>
struct FormulaScalar;
template <ScalarExpression X, class Y>
struct FormulaScalar<X, Y> {
  using type = typename X::ExpressionScalar;
};
template <class X, ScalarExpression Y>
requires(!ScalarExpression<X>) struct FormulaScalar<X, Y> {
  using type = typename Y::ExpressionScalar;
};
template <class X, class Y>
requires DualOperands<X, Y>
struct FormulaScalar<X, Y> {
  static constexpr bool is_x = [] {
    if constexpr (DualNumber<X>) {
      return std::convertible_to<Y, X>;
    } else {
      return false;
    }
  }();
  using type = std::conditional_t<is_x, X, Y>;
};
template <class X, class Y>
using ScalarOf = typename FormulaScalar<X, Y>::type;

/// The argument of a function of one number; of an array, element by element.
template <class X>
concept Argument = Differentiable<X> || DifferentiableArray<X>;

/// Two operands: one an array variable or formula, the other any operand that goes with it element by
/// element. arrays/elementwise.hpp knows which, and defines array_unary() and array_binary().
template <class X, class Y>
struct ArePairable : std::false_type {};
template <class X, class Y>
concept ArrayPair = ArePairable<std::remove_cvref_t<X>, std::remove_cvref_t<Y>>::value;
template <class Operation, DifferentiableArray X>
[[nodiscard]] auto array_unary(const X& x, const Operation& operation = Operation());
template <class Operation, class X, class Y>
[[nodiscard]] auto array_binary(const char* name, const X& x, const Y& y);

template <class X, class Y>
concept Arguments = FormulaOperands<X, Y> || ArrayPair<X, Y>;

template <class Operation, Argument X>
[[nodiscard]] auto make_unary(const X& x) {
  if constexpr (DualNumber<X>) {
    return dual_unary<Operation>(x);
  } else if constexpr (ScalarExpression<X>) {
    return Unary<Operation, X>(x);
  } else {
    return array_unary<Operation>(x);
  }
}

/// A formula itself, or a number as one.
template <class T, class X>
[[nodiscard]] auto as_expression(const X& x) {
  if constexpr (ScalarExpression<X>) {
    return x;
  } else {
    return ConstantLeaf<T>(static_cast<T>(x));
  }
}

/// A constant takes the other operand's scalar type.
/// \param name  for errors of arrays whose shapes differ
template <class Operation, class X, class Y>
[[nodiscard]] auto make_binary(const X& x, const Y& y, [[maybe_unused]] const char* name = nullptr) {
  if constexpr (!FormulaOperands<X, Y>) {
    return array_binary<Operation>(name, x, y);
  } else if constexpr (DualOperands<X, Y>) {
    return dual_binary<Operation, ScalarOf<X, Y>>(x, y);
  } else if constexpr (!ScalarExpression<X>) {
    using T = ScalarOf<X, Y>;
    return Binary<Operation, ConstantLeaf<T>, Y>(ConstantLeaf<T>(static_cast<T>(x)), y);
  } else if constexpr (!ScalarExpression<Y>) {
    using T = ScalarOf<X, Y>;
    return Binary<Operation, X, ConstantLeaf<T>>(x, ConstantLeaf<T>(static_cast<T>(y)));
  } else {
    return Binary<Operation, X, Y>(x, y);
  }
}

/// The number of type T of an operand, without its derivatives.
template <std::floating_point T, class X>
[[nodiscard]] T value_of(const X& x) {
  if constexpr (Number<X>) {
    return static_cast<T>(x);
  } else {
    return value_of<T>(x.value());
  }
}

template <Differentiable X>
[[nodiscard]] auto base_value(const X& x) {
  if constexpr (ScalarExpression<X>) {
    return value_of<Base<typename X::ExpressionScalar>>(x);
  } else {
    return value_of<Base<X>>(x);
  }
}
}  // namespace tapestry::detail

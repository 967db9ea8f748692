#pragma once
#include <concepts>
#include <cstddef>
#include <tapestry/autodiff/dual_number.hpp>
#include <tapestry/autodiff/tape_state.hpp>
#include <type_traits>

namespace tapestry {

/// A Variable, or a formula of Variables and numbers that has not been assigned to one yet.
/// It has value(), is_active(), and push(factor, sink), which hands factor · (partial derivative by v) to
/// the sink for each variable v in it.
template <class E>
concept ScalarExpression = requires {
  typename std::remove_cvref_t<E>::ExpressionScalar;
};

/// What the functions of functions.hpp take: a Variable, a formula of Variables, or a Dual.
template <class E>
concept Differentiable = ScalarExpression<E> || DualNumber<E>;

namespace detail {

/// A constant of scalar type T: a number, or a dual that is T or converts to it.
template <class X, class T>
concept ConstantOf = Number<X> ||(DualNumber<X>&& std::convertible_to<X, T>);

/// What an operator takes beside a Variable<T>.
template <class Y, class T>
concept OperandBeside = ScalarExpression<Y> || ConstantOf<Y, T>;

template <class T>
class Constant {
 public:
  using ExpressionScalar = T;
  static constexpr std::size_t operand_bound = 0;
  explicit constexpr Constant(T value) : value_(value) {}
  [[nodiscard]] constexpr T value() const { return value_; }
  [[nodiscard]] constexpr bool is_active() const { return false; }
  template <class Sink>
  constexpr void push(T, Sink&) const {}

 private:
  T value_;
};

template <class Operation, class T, class Operand, class Sink>
void push_partial(const Operand& operand, T factor, T partial, Sink& sink) {
  if constexpr (SkipsZero<Operation>) {
    if (is_zero(partial)) return;
  }
  operand.push(chain(factor, partial), sink);
}

/// f(x), where Operation has value(x) and partial(x, f(x)).
template <class Operation, class X>
class Unary {
 public:
  using ExpressionScalar = typename X::ExpressionScalar;
  using T = ExpressionScalar;
  static constexpr std::size_t operand_bound = X::operand_bound;
  explicit Unary(const X& x) : x_(x), value_(Operation::value(x.value())) {}
  [[nodiscard]] T value() const { return value_; }
  [[nodiscard]] bool is_active() const { return x_.is_active(); }
  template <class Sink>
  void push(T factor, Sink& sink) const {
    push_partial<Operation>(x_, factor, Operation::partial(x_.value(), value_), sink);
  }

 private:
  X x_;
  T value_;
};

/// f(x, y), where Operation has value(x, y), partial_x(x, y, f) and partial_y(x, y, f).
template <class Operation, class X, class Y>
class Binary {
 public:
  using ExpressionScalar = typename X::ExpressionScalar;
  using T = ExpressionScalar;
  static_assert(std::is_same_v<T, typename Y::ExpressionScalar>, "variables of float and double do not mix");
  static constexpr std::size_t operand_bound = X::operand_bound + Y::operand_bound;
  Binary(const X& x, const Y& y) : x_(x), y_(y), value_(Operation::value(x.value(), y.value())) {}
  [[nodiscard]] T value() const { return value_; }
  [[nodiscard]] bool is_active() const { return x_.is_active() || y_.is_active(); }
  template <class Sink>
  void push(T factor, Sink& sink) const {
    if constexpr (X::operand_bound != 0) {
      push_partial<Operation>(x_, factor, Operation::partial_x(x_.value(), y_.value(), value_), sink);
    }
    if constexpr (Y::operand_bound != 0) {
      push_partial<Operation>(y_, factor, Operation::partial_y(x_.value(), y_.value(), value_), sink);
    }
  }

 private:
  X x_;
  Y y_;
  T value_;
};

/// Two operands that make a formula: both expressions, or one of them and a constant.
template <class X, class Y>
concept ExpressionOperands = (ScalarExpression<X> && ScalarExpression<Y>) ||
                             (ScalarExpression<X> &&
                              ConstantOf<Y, typename std::remove_cvref_t<X>::ExpressionScalar>) ||
                             (ScalarExpression<Y> &&
                              ConstantOf<X, typename std::remove_cvref_t<Y>::ExpressionScalar>);

/// Two operands of which one is a Dual, and the other the same Dual or a constant beside it.
template <class X, class Y>
concept DualOperands = (DualNumber<X> &&
                        (std::same_as<X, Y> || std::convertible_to<Y, typename X::value_type>)) ||
                       (DualNumber<Y> && std::convertible_to<X, typename Y::value_type>);

/// The operands of a differentiable function of two.
template <class X, class Y>
concept FormulaOperands = ExpressionOperands<X, Y> || DualOperands<X, Y>;

/// The scalar type of a formula of x and y.
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

template <class Operation, Differentiable X>
[[nodiscard]] auto make_unary(const X& x) {
  if constexpr (DualNumber<X>) {
    return dual_unary<Operation>(x);
  } else {
    return Unary<Operation, X>(x);
  }
}

/// A constant takes the other operand's scalar type.
template <class Operation, class X, class Y>
requires FormulaOperands<X, Y>
[[nodiscard]] auto make_binary(const X& x, const Y& y) {
  using T = ScalarOf<X, Y>;
  if constexpr (DualOperands<X, Y>) {
    return dual_binary<Operation, T>(x, y);
  } else if constexpr (!ScalarExpression<X>) {
    return Binary<Operation, Constant<T>, Y>(Constant<T>(static_cast<T>(x)), y);
  } else if constexpr (!ScalarExpression<Y>) {
    return Binary<Operation, X, Constant<T>>(x, Constant<T>(static_cast<T>(y)));
  } else {
    return Binary<Operation, X, Y>(x, y);
  }
}

/// The number of type T that an operand stands for, whatever it carries.
template <std::floating_point T, class X>
[[nodiscard]] T value_of(const X& x) {
  if constexpr (Number<X>) {
    return static_cast<T>(x);
  } else {
    return value_of<T>(x.value());
  }
}

/// The number beneath a differentiable scalar.
template <Differentiable X>
[[nodiscard]] auto base_value(const X& x) {
  if constexpr (ScalarExpression<X>) {
    return value_of<Base<typename X::ExpressionScalar>>(x);
  } else {
    return value_of<Base<X>>(x);
  }
}

}  // namespace detail
}  // namespace tapestry

#pragma once
#include <cstddef>
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

template <class E>
concept Number = std::is_arithmetic_v<std::remove_cvref_t<E>>;

namespace detail {

/// factor · partial; nothing passes a zero factor, not even an infinite partial.
template <class T>
[[nodiscard]] constexpr T chain(T factor, T partial) {
  return factor == T(0) ? T(0) : factor * partial;
}

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

/// Operations at a kink name one side and give the other the partial 0; it must then stay out of the
/// statement, so that an infinite adjoint cannot turn it into NaN. They say so with `skips_zero`.
template <class Operation>
concept SkipsZero = requires {
  Operation::skips_zero;
};

template <class Operation, class T, class Operand, class Sink>
void push_partial(const Operand& operand, T factor, T partial, Sink& sink) {
  if constexpr (SkipsZero<Operation>) {
    if (partial == T(0)) return;
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

template <class Operation, ScalarExpression X>
[[nodiscard]] auto make_unary(const X& x) {
  return Unary<Operation, X>(x);
}

/// At least one of x and y is an expression; a number takes the other's scalar type.
template <class Operation, class X, class Y>
[[nodiscard]] auto make_binary(const X& x, const Y& y) {
  if constexpr (Number<X>) {
    using T = typename Y::ExpressionScalar;
    return Binary<Operation, Constant<T>, Y>(Constant<T>(static_cast<T>(x)), y);
  } else if constexpr (Number<Y>) {
    using T = typename X::ExpressionScalar;
    return Binary<Operation, X, Constant<T>>(x, Constant<T>(static_cast<T>(y)));
  } else {
    return Binary<Operation, X, Y>(x, y);
  }
}

/// Two operands that make a formula: both expressions, or one of them and a number.
template <class X, class Y>
concept FormulaOperands = (ScalarExpression<X> && (ScalarExpression<Y> || Number<Y>)) ||
                          (Number<X> && ScalarExpression<Y>);

/// The scalar type of a formula of x and y.
template <class X, class Y>
struct FormulaScalar {
  using type = typename X::ExpressionScalar;
};
template <Number X, class Y>
struct FormulaScalar<X, Y> {
  using type = typename Y::ExpressionScalar;
};
template <class X, class Y>
using ScalarOf = typename FormulaScalar<X, Y>::type;

/// The number that an operand stands for.
template <class T, class X>
[[nodiscard]] T value_of(const X& x) {
  if constexpr (Number<X>) {
    return static_cast<T>(x);
  } else {
    return x.value();
  }
}

}  // namespace detail
}  // namespace tapestry

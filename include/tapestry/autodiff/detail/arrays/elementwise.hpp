#pragma once
#include <tapestry/autodiff/detail/arrays/expression/evaluate.hpp>
#include <tapestry/autodiff/functions.hpp>

namespace tapestry {
namespace detail {
template <class X>
struct ArrayScalarOf {};
template <class T, std::size_t Rank>
struct ArrayScalarOf<ArrayVariable<T, Rank>> {
  using type = T;
};
template <ArrayExpression X>
struct ArrayScalarOf<X> {
  using type = typename X::ArrayScalar;
};

template <class X>
using ArrayScalarType = typename ArrayScalarOf<std::remove_cvref_t<X>>::type;

/// An operand beside arrays of T and Rank: a number, a scalar variable or formula, an array or a formula of
/// arrays, passive if plain.
template <class X, class T, std::size_t Rank>
concept ArrayOperand = DifferentiableArray<X> || std::is_convertible_v<const X&, ArrayVariable<T, Rank>> ||
    ScalarExpression<X> || Number<X>;

template <class T, std::size_t Rank, class X>
[[nodiscard]] auto to_node(const X& x) {
  if constexpr (ArrayExpression<X>) {
    return x;
  } else if constexpr (Number<X>) {
    return NumberNode<T>{static_cast<T>(x)};
  } else if constexpr (ScalarExpression<X>) {
    return ScalarNode<T>{Variable<T>(x)};
  } else if constexpr (DifferentiableArray<X>) {
    return whole_view(x);
  } else {
    return ConstantView<T, Rank, Rank>(whole_view(ArrayVariable<T, Rank>(x)));
  }
}
template <DifferentiableArray X>
[[nodiscard]] auto to_node(const X& x) {
  return to_node<ArrayScalarType<X>, X::rank>(x);
}

template <DifferentiableArray X, class Y>
struct ArePairable<X, Y> : std::bool_constant<ArrayOperand<Y, ArrayScalarType<X>, X::rank>> {};
template <class X, DifferentiableArray Y>
requires(!DifferentiableArray<X>) struct ArePairable<X, Y>
    : std::bool_constant<ArrayOperand<X, ArrayScalarType<Y>, Y::rank>> {
};

template <class Operation, DifferentiableArray X>
[[nodiscard]] auto array_unary(const X& x, const Operation& operation) {
  auto node = to_node(x);
  return ArrayUnary<Operation, decltype(node)>(operation, std::move(node));
}

template <class Operation, class X, class Y>
[[nodiscard]] auto array_binary(const char* name, const X& x, const Y& y) {
  using Leader = std::conditional_t<DifferentiableArray<X>, X, Y>;
  using T = ArrayScalarType<Leader>;
  auto left = to_node<T, Leader::rank>(x);
  auto right = to_node<T, Leader::rank>(y);
  return ArrayBinary<Operation, decltype(left), decltype(right)>(name, std::move(left), std::move(right));
}

/// Comparisons are 1 where they hold and 0 elsewhere, and have no derivative.
template <class Compare>
struct Comparison {
  static constexpr bool is_cheap = true;
  static constexpr bool has_no_derivative = true;
  static auto value(auto x, auto y) { return Compare()(x, y) ? decltype(x)(1) : decltype(x)(0); }
};
/// x / divisor; its derivative is one division for all elements.
template <class T>
struct DivideByNumber {
  static constexpr bool is_cheap = true;
  explicit DivideByNumber(T number) : divisor(number), reciprocal(T(1) / number) {}
  [[nodiscard]] T value(T x) const { return x / divisor; }
  [[nodiscard]] T partial(T, T) const { return reciprocal; }

  T divisor;
  T reciprocal;
};

template <class T>
struct Clamp {
  static constexpr bool is_cheap = true;
  static constexpr bool skips_zero = true;
  T low;
  T high;
  [[nodiscard]] T value(T x) const { return AtMost::value(AtLeast::value(x, low), high); }
  [[nodiscard]] T partial(T x, T) const {
    const T raised = AtLeast::value(x, low);
    return AtLeast::partial_x(x, low, raised) * AtMost::partial_x(raised, high, raised);
  }
};
}  // namespace detail

// Element by element, as a formula: computed in one pass when it becomes an ArrayVariable or is summed, and
// pulled back in one pass. One operand is an array variable, a view or a formula of these; the other is
// another such operand of the same rank or of rank 0, a plain array, a scalar variable or formula, or a
// number. Axes of extent 1 and arrays of no axes repeat; the adjoint of a repeated operand, and of a scalar,
// sums over the elements. functions.hpp has the other functions of elements. As everywhere on the tape, a
// zero adjoint passes nothing on, even where a partial derivative is infinite or NaN, so a masked element
// cannot poison the gradient. Kinks and poles are treated as by the scalar functions of the same name.
// \throws ShapeError if extents do not go together.

template <class X, class Y>
requires detail::ArrayPair<X, Y>
[[nodiscard]] auto operator+(X&& x, Y&& y) { return detail::array_binary<detail::Plus>("operator+", x, y); }

template <class X, class Y>
requires detail::ArrayPair<X, Y>
[[nodiscard]] auto operator-(X&& x, Y&& y) { return detail::array_binary<detail::Minus>("operator-", x, y); }

template <class X, class Y>
requires detail::ArrayPair<X, Y>
[[nodiscard]] auto operator*(X&& x, Y&& y) { return detail::array_binary<detail::Times>("operator*", x, y); }

template <class X, detail::ArrayPair<X> Y>
[[nodiscard]] auto operator/(X&& x, Y&& y) {
  if constexpr (Number<Y>) {
    using T = detail::ArrayScalarType<X>;
    return detail::array_unary(x, detail::DivideByNumber<T>(static_cast<T>(y)));
  } else {
    return detail::array_binary<detail::Divide>("operator/", x, y);
  }
}

/// 1 where x < y and 0 elsewhere, without a derivative: a mask for where().
template <class X, detail::ArrayPair<X> Y>
[[nodiscard]] auto operator<(X&& x, Y&& y) {
  return detail::array_binary<detail::Comparison<std::less<>>>("operator<", x, y);
}
template <class X, detail::ArrayPair<X> Y>
[[nodiscard]] auto operator<=(X&& x, Y&& y) {
  return detail::array_binary<detail::Comparison<std::less_equal<>>>("operator<=", x, y);
}
template <class X, detail::ArrayPair<X> Y>
[[nodiscard]] auto operator>(X&& x, Y&& y) {
  return detail::array_binary<detail::Comparison<std::less<>>>("operator>", y, x);
}
template <class X, detail::ArrayPair<X> Y>
[[nodiscard]] auto operator>=(X&& x, Y&& y) {
  return detail::array_binary<detail::Comparison<std::less_equal<>>>("operator>=", y, x);
}

/// Marks x as constant in a formula, at compile time: it costs no pullback at all, while a variable that
/// happens to be passive costs the arithmetic.
template <class T, std::size_t Rank>
[[nodiscard]] auto constant(const ArrayVariable<T, Rank>& x) {
  return detail::ConstantView<T, Rank, Rank>(detail::whole_view(x));
}
template <class T, std::size_t Whole, std::size_t Rank>
[[nodiscard]] auto constant(const ArrayView<T, Whole, Rank>& x) {
  return detail::ConstantView<T, Whole, Rank>(x);
}

/// x where the mask is not 0, and y elsewhere. The side not taken receives no gradient, even where it is
/// infinite or NaN.
template <DifferentiableArray M, detail::ArrayPair<M> X, detail::ArrayPair<M> Y>
[[nodiscard]] auto where(const M& mask, const X& x, const Y& y) {
  using T = detail::ArrayScalarType<M>;
  auto m = detail::to_node(mask);
  auto first = detail::to_node<T, M::rank>(x);
  auto second = detail::to_node<T, M::rank>(y);
  return detail::ArrayWhere<decltype(m), decltype(first), decltype(second)>(std::move(m), std::move(first),
                                                                            std::move(second));
}

/// Each element clamped to [low, high]. A NaN stays NaN. The derivative is 1 on the closed interval and
/// for a NaN, and 0 outside.
template <DifferentiableArray X>
[[nodiscard]] auto clamp(const X& x, std::type_identity_t<detail::ArrayScalarType<X>> low,
                         std::type_identity_t<detail::ArrayScalarType<X>> high) {
  return detail::array_unary(x, detail::Clamp<detail::ArrayScalarType<X>>{low, high});
}
}  // namespace tapestry

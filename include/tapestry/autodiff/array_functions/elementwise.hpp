#pragma once
#include <cstddef>
#include <memory>
#include <tapestry/autodiff/functions.hpp>
#include <tapestry/autodiff/record.hpp>
#include <tapestry/core/array.hpp>
#include <tapestry/core/check.hpp>
#include <type_traits>

namespace tapestry {
namespace detail {

/// What a pullback keeps of an operand, indexed like an array; a scalar repeats.
template <class T, std::size_t Rank>
struct KeptArray {
  std::shared_ptr<const Array<T, Rank>> array;
  [[nodiscard]] const T* elements() const { return array->data(); }
};
template <class T>
struct KeptScalar {
  T scalar;
  struct Repeated {
    T value;
    T operator[](std::size_t) const { return value; }
  };
  [[nodiscard]] Repeated elements() const { return {scalar}; }
};

template <class T, std::size_t Rank>
[[nodiscard]] KeptArray<T, Rank> keep(const ArrayVariable<T, Rank>& x) {
  return {x.shared_value()};
}
template <class T>
[[nodiscard]] KeptScalar<T> keep(const Variable<T>& x) {
  return {x.value()};
}

/// Adds term(i) to adjoint[i], or all of them, in order and in double, to the adjoint of a scalar.
template <class T, std::size_t Rank, class Term>
void add_terms(Array<T, Rank>* adjoint, std::size_t count, Term term) {
  if (adjoint == nullptr) return;
  T* const elements = adjoint->data();
  for (std::size_t i = 0; i < count; ++i) elements[i] += term(i);
}
template <class T, class Term>
void add_terms(T* adjoint, std::size_t count, Term term) {
  if (adjoint == nullptr) return;
  double total = 0;
  for (std::size_t i = 0; i < count; ++i) total += static_cast<double>(term(i));
  *adjoint += static_cast<T>(total);
}

/// f(x) of each element, for an Operation of functions/.
template <class Operation, class T, std::size_t Rank>
[[nodiscard]] ArrayVariable<T, Rank> elementwise(const ArrayVariable<T, Rank>& x) {
  const auto value = std::make_shared<Array<T, Rank>>(x.shape());
  const T* const from = x.value().data();
  T* const to = value->data();
  for (std::size_t i = 0; i < x.size(); ++i) to[i] = Operation::value(from[i]);
  const auto pullback = [kept_x = keep(x), kept_value = std::shared_ptr<const Array<T, Rank>>(value)](
                            const Array<T, Rank>& value_adjoint, Array<T, Rank>* x_adjoint) {
    const T* const g = value_adjoint.data();
    const T* const a = kept_x.elements();
    const T* const f = kept_value->data();
    add_terms(x_adjoint, value_adjoint.size(),
              [=](std::size_t i) { return chain(g[i], Operation::partial(a[i], f[i])); });
  };
  return record_array(std::shared_ptr<const Array<T, Rank>>(value), pullback, x);
}

/// f(x, y) of each pair of elements, where x or y may be a scalar variable.
template <class Operation, class T, std::size_t Rank, class X, class Y>
[[nodiscard]] ArrayVariable<T, Rank> elementwise(const Extents<Rank>& extents, const X& x, const Y& y) {
  const auto value = std::make_shared<Array<T, Rank>>(extents);
  const auto from_x = keep(x).elements();
  const auto from_y = keep(y).elements();
  T* const to = value->data();
  for (std::size_t i = 0; i < value->size(); ++i) to[i] = Operation::value(from_x[i], from_y[i]);
  const auto pullback = [kept_x = keep(x), kept_y = keep(y),
                         kept_value = std::shared_ptr<const Array<T, Rank>>(value)](
                            const Array<T, Rank>& value_adjoint, auto* x_adjoint, auto* y_adjoint) {
    const T* const g = value_adjoint.data();
    const auto a = kept_x.elements();
    const auto b = kept_y.elements();
    const T* const f = kept_value->data();
    add_terms(x_adjoint, value_adjoint.size(),
              [=](std::size_t i) { return chain(g[i], Operation::partial_x(a[i], b[i], f[i])); });
    add_terms(y_adjoint, value_adjoint.size(),
              [=](std::size_t i) { return chain(g[i], Operation::partial_y(a[i], b[i], f[i])); });
  };
  return record_array(std::shared_ptr<const Array<T, Rank>>(value), pullback, x, y);
}

template <class X>
struct IsArrayVariable : std::false_type {};
template <class T, std::size_t Rank>
struct IsArrayVariable<ArrayVariable<T, Rank>> : std::true_type {};
template <class X>
concept AnyArrayVariable = IsArrayVariable<std::remove_cvref_t<X>>::value;

/// An operand beside an array: a number, a scalar variable or formula, or an array, passive if plain.
template <class X, class T, std::size_t Rank>
concept ArrayOperand =
    std::is_convertible_v<const X&, ArrayVariable<T, Rank>> || ScalarExpression<X> || Number<X>;

template <class T, std::size_t Rank, class X>
[[nodiscard]] auto to_operand(const X& x) {
  if constexpr (ScalarExpression<X> || Number<X>) {
    return Variable<T>(x);
  } else {
    return ArrayVariable<T, Rank>(x);
  }
}

/// f(x, y) where at least one of the two is an ArrayVariable, which sets scalar type and extents.
template <class Operation, class X, class Y>
[[nodiscard]] auto elementwise_of(const char* name, const X& x, const Y& y) {
  if constexpr (AnyArrayVariable<X>) {
    using T = typename X::value_type;
    const auto other = to_operand<T, X::rank>(y);
    if constexpr (AnyArrayVariable<decltype(other)>)
      require_shape(name, "right operand", other.value(), x.shape());
    return elementwise<Operation, T, X::rank>(x.shape(), x, other);
  } else {
    using T = typename Y::value_type;
    const auto other = to_operand<T, Y::rank>(x);
    if constexpr (AnyArrayVariable<decltype(other)>)
      require_shape(name, "left operand", other.value(), y.shape());
    return elementwise<Operation, T, Y::rank>(y.shape(), other, y);
  }
}

template <class X, class Y>
struct ArePairable : std::false_type {};
template <class T, std::size_t Rank, class Y>
struct ArePairable<ArrayVariable<T, Rank>, Y> : std::bool_constant<ArrayOperand<Y, T, Rank>> {};
template <class X, class T, std::size_t Rank>
requires(!AnyArrayVariable<X>) struct ArePairable<X, ArrayVariable<T, Rank>>
    : std::bool_constant<ArrayOperand<X, T, Rank>> {
};
/// One is an ArrayVariable, the other anything that goes with it element by element.
template <class X, class Y>
concept ArrayPair = ArePairable<std::remove_cvref_t<X>, std::remove_cvref_t<Y>>::value;
}  // namespace detail

// Element by element. One operand is an ArrayVariable; the other is one of the same extents, a plain array,
// a scalar variable or formula, or a number; of a scalar, the adjoint sums over the elements. As everywhere
// on the tape, a zero adjoint passes nothing on, even where a partial derivative is infinite or NaN, so a
// masked element cannot poison the gradient. \throws ShapeError if extents differ.

template <class X, class Y>
requires detail::ArrayPair<X, Y>
[[nodiscard]] auto operator+(X&& x, Y&& y) { return detail::elementwise_of<detail::Plus>("operator+", x, y); }

template <class X, class Y>
requires detail::ArrayPair<X, Y>
[[nodiscard]] auto operator-(X&& x, Y&& y) {
  return detail::elementwise_of<detail::Minus>("operator-", x, y);
}

template <class X, class Y>
requires detail::ArrayPair<X, Y>
[[nodiscard]] auto operator*(X&& x, Y&& y) {
  return detail::elementwise_of<detail::Times>("operator*", x, y);
}

template <class X, class Y>
requires detail::ArrayPair<X, Y>
[[nodiscard]] auto operator/(X&& x, Y&& y) {
  return detail::elementwise_of<detail::Divide>("operator/", x, y);
}

template <class X, class Y>
requires detail::ArrayPair<X, Y>
[[nodiscard]] auto pow(const X& x, const Y& y) { return detail::elementwise_of<detail::Pow>("pow", x, y); }

/// At a tie the first argument has the whole derivative.
template <class X, class Y>
requires detail::ArrayPair<X, Y>
[[nodiscard]] auto max(const X& x, const Y& y) { return detail::elementwise_of<detail::Max>("max", x, y); }

template <class X, class Y>
requires detail::ArrayPair<X, Y>
[[nodiscard]] auto min(const X& x, const Y& y) { return detail::elementwise_of<detail::Min>("min", x, y); }

template <class T, std::size_t R>
[[nodiscard]] auto operator-(const ArrayVariable<T, R>& x) {
  return detail::elementwise<detail::Negate>(x);
}

template <class T, std::size_t R>
[[nodiscard]] auto exp(const ArrayVariable<T, R>& x) {
  return detail::elementwise<detail::Exp>(x);
}

template <class T, std::size_t R>
[[nodiscard]] auto log(const ArrayVariable<T, R>& x) {
  return detail::elementwise<detail::Log>(x);
}

template <class T, std::size_t R>
[[nodiscard]] auto sqrt(const ArrayVariable<T, R>& x) {
  return detail::elementwise<detail::Sqrt>(x);
}

template <class T, std::size_t R>
[[nodiscard]] auto square(const ArrayVariable<T, R>& x) {
  return detail::elementwise<detail::Square>(x);
}

template <class T, std::size_t R>
[[nodiscard]] auto tanh(const ArrayVariable<T, R>& x) {
  return detail::elementwise<detail::Tanh>(x);
}

template <class T, std::size_t R>
[[nodiscard]] auto sigmoid(const ArrayVariable<T, R>& x) {
  return detail::elementwise<detail::Sigmoid>(x);
}

template <class T, std::size_t R>
[[nodiscard]] auto softplus(const ArrayVariable<T, R>& x) {
  return detail::elementwise<detail::Softplus>(x);
}

template <class T, std::size_t R>
[[nodiscard]] auto abs(const ArrayVariable<T, R>& x) {
  return detail::elementwise<detail::Abs>(x);
}

/// Each element held within [low, high]; the derivative is 1 on the closed interval and 0 outside.
template <class T, std::size_t R>
[[nodiscard]] auto clamp(const ArrayVariable<T, R>& x, std::type_identity_t<T> low,
                         std::type_identity_t<T> high) {
  Array<T, R> value(x.shape());
  for (std::size_t i = 0; i < x.size(); ++i)
    value.data()[i] = detail::Min::value(detail::Max::value(x.value().data()[i], low), high);
  const auto pullback = [kept = detail::keep(x), low, high](const Array<T, R>& value_adjoint,
                                                            Array<T, R>* x_adjoint) {
    const T* const a = kept.elements();
    detail::add_terms(x_adjoint, value_adjoint.size(), [&](std::size_t i) {
      return a[i] >= low && a[i] <= high ? value_adjoint.data()[i] : T(0);
    });
  };
  return record_array(std::move(value), pullback, x);
}

}  // namespace tapestry

#pragma once
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <type_traits>

namespace tapestry {

template <class T, std::size_t N, class Tag>
class Dual;

/// A plain number.
template <class E>
concept Number = std::is_arithmetic_v<std::remove_cvref_t<E>>;

namespace detail {
template <class X>
struct IsDual : std::false_type {};
template <class T, std::size_t N, class Tag>
struct IsDual<Dual<T, N, Tag>> : std::true_type {};
}  // namespace detail

/// A number that carries its own derivatives; see dual.hpp.
template <class X>
concept DualNumber = detail::IsDual<std::remove_cvref_t<X>>::value;

/// A number that a tape can compute with: floating point, or a dual number for derivatives of gradients.
template <class T>
concept Scalar = std::floating_point<T> || DualNumber<T>;

namespace detail {

/// Whether T is a Scalar: for static_assert, whose message would otherwise explain the concept, too.
template <class T>
inline constexpr bool is_scalar = Scalar<T>;

/// The floating-point type at the bottom of a scalar type.
template <class T>
struct BaseOf {
  using type = T;
};
template <class T, std::size_t N, class Tag>
struct BaseOf<Dual<T, N, Tag>> {
  using type = typename BaseOf<T>::type;
};
template <class T>
using Base = typename BaseOf<std::remove_cvref_t<T>>::type;

/// Whether all numbers of a scalar are zero: its value, and the derivatives that it carries.
template <std::floating_point T>
[[nodiscard]] constexpr bool is_zero(T x) {
  return x == T(0);
}
template <DualNumber T>
[[nodiscard]] constexpr bool is_zero(const T& x) {
  return x.is_zero();
}

/// a || b, without a branch that would keep a loop from being one of vectors.
[[nodiscard]] constexpr bool either(bool a, bool b) {
  return (static_cast<int>(a) | static_cast<int>(b)) != 0;
}

/// factor · partial, of which a zero on either side passes nothing, not even from infinity or a NaN: a
/// product of slopes is then the same from either end, on the tape and in duals. The product comes first, so
/// that loops of this need no branch.
template <std::floating_point T>
[[nodiscard]] constexpr T chain(T factor, T partial) {
  const T product = factor * partial;
  return either(factor == T(0), partial == T(0)) ? T(0) : product;
}

/// NaN, and so all that it carries.
template <class T>
[[nodiscard]] constexpr T unknown() {
  if constexpr (std::floating_point<T>) {
    return std::numeric_limits<T>::quiet_NaN();
  } else {
    auto tangents = T().tangents();
    for (auto& tangent : tangents) tangent = unknown<typename T::value_type>();
    return {unknown<typename T::value_type>(), tangents};
  }
}

/// Whether a number of 0 that has the tangent NaN, as the slope at a kink, meets one that changes.
template <class T>
[[nodiscard]] constexpr bool meets_kink(const T& number, const T& tangent, const T& other_tangent) {
  return number == 0 && tangent != tangent && !is_zero(other_tangent);
}

template <DualNumber T>
[[nodiscard]] constexpr T chain(const T& factor, const T& partial) {
  auto tangents = factor.tangents();
  for (std::size_t k = 0; k < T::direction_count; ++k)
    tangents[k] = chain(factor.tangent(k), partial.value()) + chain(factor.value(), partial.tangent(k));
  if (either(factor.value() == 0, partial.value() == 0)) [[unlikely]]
    for (std::size_t k = 0; k < T::direction_count; ++k)
      if (either(meets_kink(factor.value(), factor.tangent(k), partial.tangent(k)),
                 meets_kink(partial.value(), partial.tangent(k), factor.tangent(k))))
        tangents[k] = unknown<typename T::value_type>();
  return {chain(factor.value(), partial.value()), tangents};
}

/// Whether chain() of two numbers hid one that is not finite.
template <std::floating_point T>
[[nodiscard]] bool hides_infinity(T factor, T partial) {
  return (factor == T(0) && !std::isfinite(partial)) || (partial == T(0) && !std::isfinite(factor));
}
template <DualNumber T>
[[nodiscard]] bool hides_infinity(const T& factor, const T& partial) {
  bool hides = hides_infinity(factor.value(), partial.value());
  for (std::size_t k = 0; k < T::direction_count; ++k)
    hides = hides || hides_infinity(factor.tangent(k), partial.value()) ||
            hides_infinity(factor.value(), partial.tangent(k));
  return hides;
}

/// Operations at a kink name one side and give the other the partial 0, which is left out of the statement.
/// They declare `skips_zero`.
template <class Operation>
concept SkipsZero = requires {
  Operation::skips_zero;
};

/// Whether an operation is at a kink or has an infinite slope, given its operands' values: it declares
/// is_kink() of them.
template <class Operation, class... Values>
[[nodiscard]] constexpr bool is_at_kink(const Values&... values) {
  if constexpr (requires { Operation::is_kink(values...); }) {
    return Operation::is_kink(values...);
  } else {
    return false;
  }
}

/// Operations whose slope at a kink is 0, a subgradient that belongs to no side. They declare
/// `is_subgradient`.
template <class Operation>
concept HasSubgradient = requires {
  Operation::is_subgradient;
};

/// The number beneath f, and NaN for its derivatives in directions in which x changes.
template <class T>
[[nodiscard]] constexpr T unknown_along(const T& f, const T& x) {
  if constexpr (std::floating_point<T>) {
    return f;
  } else {
    auto tangents = f.tangents();
    for (std::size_t k = 0; k < T::direction_count; ++k)
      if (!is_zero(x.tangent(k))) tangents[k] = unknown<typename T::value_type>();
    return {unknown_along(f.value(), x.value()), tangents};
  }
}

/// The value of an operation, f, and its slope, as numbers whose own derivatives are asked for: at a kink
/// with a subgradient these are not known, where 0 would pass for one. A zero does not hide them, see
/// chain().
template <class Operation, class T, class... Values>
[[nodiscard]] constexpr T value_at(T f, const Values&... values) {
  if constexpr (DualNumber<T> && HasSubgradient<Operation>)
    if (is_at_kink<Operation>(values...)) [[unlikely]]
      ((f = unknown_along(f, values)), ...);
  return f;
}
template <class Operation, class T, class... Values>
[[nodiscard]] constexpr T slope_at(const T& slope, const Values&... values) {
  if constexpr (DualNumber<T> && HasSubgradient<Operation>)
    if (is_at_kink<Operation>(values...)) [[unlikely]]
      return unknown_along(slope, unknown<T>());
  return slope;
}

}  // namespace detail
}  // namespace tapestry

#pragma once
#include <cmath>
#include <concepts>
#include <cstddef>
#include <limits>
#include <type_traits>

#if defined(__FINITE_MATH_ONLY__) && __FINITE_MATH_ONLY__ > 0 && !defined(TAPESTRY_ALLOW_FINITE_MATH)
#pragma GCC warning \
    "-ffast-math loses NaN and infinities, by which Tapestry marks derivatives that do not exist: add -fno-finite-math-only, or define TAPESTRY_ALLOW_FINITE_MATH to do without them"
#endif

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

/// The same number in double, for sums.
template <std::floating_point T>
[[nodiscard]] constexpr double widened(T x) {
  return static_cast<double>(x);
}
template <std::floating_point T>
[[nodiscard]] constexpr T narrowed(double x) {
  return static_cast<T>(x);
}

/// Whether all numbers of a scalar are zero: its value, and the derivatives that it carries.
template <std::floating_point T>
[[nodiscard]] constexpr bool is_zero(T x) {
  return x == T(0);
}
template <DualNumber T>
[[nodiscard]] constexpr bool is_zero(const T& x) {
  return x.is_zero();
}

/// a || b, without a branch: loops stay vectorised.
[[nodiscard]] constexpr bool either(bool a, bool b) {
  return (static_cast<int>(a) | static_cast<int>(b)) != 0;
}

/// factor · partial; a zero on either side gives 0, even beside infinity or NaN: a product of slopes is then
/// the same from either end, on the tape and in duals. The product comes first, so that loops of this need no
/// branch.
template <std::floating_point T>
[[nodiscard]] constexpr T chain(T factor, T partial) {
  const T product = factor * partial;
  return either(factor == T(0), partial == T(0)) ? T(0) : product;
}

/// chain() where −0 may stand for 0, as in sums: one comparison instead of two.
template <std::floating_point T>
[[nodiscard, gnu::always_inline]] constexpr T chain_in_sum(T factor, T partial) {
  const T product = factor * partial;
  if (product != product) [[unlikely]]
    return either(factor == T(0), partial == T(0)) ? T(0) : product;
  return product;
}

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

template <DualNumber T>
[[nodiscard]] constexpr T chain(const T& factor, const T& partial);

/// The same for duals, whose parts may be 0 or NaN. A number of 0 that has the tangent NaN, as the slope at a
/// kink, is no zero: where it meets one that changes, the tangent of the product is NaN.
template <DualNumber T>
[[nodiscard, gnu::noinline]] constexpr T chain_with_care(const T& factor, const T& partial) {
  const auto meets_kink = [](const T& x, const T& y, std::size_t k) {
    return x.value() == 0 && x.tangent(k) != x.tangent(k) && !is_zero(y.tangent(k));
  };
  auto tangents = factor.tangents();
  for (std::size_t k = 0; k < T::direction_count; ++k) {
    tangents[k] = chain(factor.tangent(k), partial.value()) + chain(factor.value(), partial.tangent(k));
    if (meets_kink(factor, partial, k) || meets_kink(partial, factor, k))
      tangents[k] = unknown<typename T::value_type>();
  }
  return {chain(factor.value(), partial.value()), tangents};
}

/// tangent · number, which is nothing where the compiler knows the tangent to be 0, as of constants.
template <std::floating_point T>
[[nodiscard, gnu::always_inline]] constexpr T product_of(T tangent, T number) {
  return __builtin_constant_p(tangent == 0) && tangent == 0 ? T(0) : tangent * number;
}

template <DualNumber T>
[[nodiscard]] constexpr T chain(const T& factor, const T& partial) {
  using V = typename T::value_type;
  if constexpr (std::floating_point<V>) {
    const V value = factor.value() * partial.value();
    V total = 0;
    auto tangents = factor.tangents();
    for (std::size_t k = 0; k < T::direction_count; ++k) {
      tangents[k] = product_of(factor.tangent(k), partial.value()) +
                    product_of(partial.tangent(k), factor.value()) + V(0);  // no −0
      total += tangents[k];
    }
    if ((value < 0 || value > 0) && total == total) [[likely]]
      return {value, tangents};
  }
  return chain_with_care(factor, partial);
}

/// Whether chain() of two numbers took 0 · ∞ or 0 · NaN as 0.
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

/// At a kink an operation names one side. The other side has the partial 0 and is left out of the statement.
/// They declare `skips_zero`.
template <class Operation>
concept SkipsZero = requires {
  Operation::skips_zero;
};
}  // namespace detail
}  // namespace tapestry

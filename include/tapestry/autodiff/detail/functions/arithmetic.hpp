#pragma once
#include <compare>
#include <iosfwd>
#include <tapestry/autodiff/detail/tape/formula.hpp>

namespace tapestry {
namespace detail {
struct Plus {
  static constexpr bool is_cheap = true;
  using SlopeX = One;
  using SlopeY = One;
  static auto value(const auto& x, const auto& y) { return x + y; }
  static auto partial_x(auto x, auto, auto) { return decltype(x)(1); }
  static auto partial_y(auto x, auto, auto) { return decltype(x)(1); }
  /// The gradient g times the partial of one side.
  static auto pass_x(auto g, auto, auto) { return g; }
  static auto pass_y(auto g, auto, auto) { return g; }
};
struct Minus {
  static constexpr bool is_cheap = true;
  using SlopeX = One;
  using SlopeY = MinusOne;
  static auto value(const auto& x, const auto& y) { return x - y; }
  static auto partial_x(auto x, auto, auto) { return decltype(x)(1); }
  static auto partial_y(auto x, auto, auto) { return decltype(x)(-1); }
  static auto pass_x(auto g, auto, auto) { return g; }
  static auto pass_y(auto g, auto, auto) { return -g; }
};
struct Times {
  static constexpr bool is_cheap = true;
  static constexpr bool is_linear_in_x = true;
  static constexpr bool is_linear_in_y = true;
  static auto value(const auto& x, const auto& y) { return x * y; }
  static auto partial_x(const auto&, const auto& y, const auto&) { return y; }
  static auto partial_y(const auto& x, const auto&, const auto&) { return x; }
};
struct Divide {
  static constexpr bool is_cheap = true;
  static constexpr bool is_linear_in_x = true;
  static bool is_kink(const auto&, const auto& y) { return y == 0; }
  static auto value(const auto& x, const auto& y) { return x / y; }
  template <class T>
  static T partial_x(const T&, const T& y, const T&) {
    return T(1) / y;
  }
  static auto partial_y(const auto&, const auto& y, const auto& quotient) { return -quotient / y; }
};
struct Negate {
  static constexpr bool is_cheap = true;
  using Slope = MinusOne;
  static auto value(const auto& x) { return -x; }
  static auto partial(auto x, auto) { return decltype(x)(-1); }
};

/// std::complex of variables or duals; it need not be included.
template <class Z>
concept ComplexOfDifferentiable = Differentiable<typename Z::value_type> && requires(const Z& z) {
  { Z(z.real(), z.imag()).real() } -> std::same_as<typename Z::value_type>;
};

template <class M>
concept MatrixOfDifferentiable = Differentiable<typename M::Scalar>;
}  // namespace detail

template <class X, class Y>
requires detail::FormulaOperands<X, Y>
[[nodiscard]] auto operator+(const X& x, const Y& y) { return detail::make_binary<detail::Plus>(x, y); }

template <class X, class Y>
requires detail::FormulaOperands<X, Y>
[[nodiscard]] auto operator-(const X& x, const Y& y) { return detail::make_binary<detail::Minus>(x, y); }

template <class X, class Y>
requires detail::FormulaOperands<X, Y>
[[nodiscard]] auto operator*(const X& x, const Y& y) { return detail::make_binary<detail::Times>(x, y); }

template <class X, class Y>
requires detail::FormulaOperands<X, Y>
[[nodiscard]] auto operator/(const X& x, const Y& y) { return detail::make_binary<detail::Divide>(x, y); }

// Complex numbers beside plain ones.
template <detail::ComplexOfDifferentiable Z, Number N>
[[nodiscard]] Z operator+(const Z& z, N x) {
  return Z(z.real() + x, z.imag());
}
template <detail::ComplexOfDifferentiable Z, Number N>
[[nodiscard]] Z operator+(N x, const Z& z) {
  return Z(x + z.real(), z.imag());
}
template <detail::ComplexOfDifferentiable Z, Number N>
[[nodiscard]] Z operator-(const Z& z, N x) {
  return Z(z.real() - x, z.imag());
}
template <detail::ComplexOfDifferentiable Z, Number N>
[[nodiscard]] Z operator-(N x, const Z& z) {
  return Z(x - z.real(), -z.imag());
}
template <detail::ComplexOfDifferentiable Z, Number N>
[[nodiscard]] Z operator*(const Z& z, N x) {
  return Z(z.real() * x, z.imag() * x);
}
template <detail::ComplexOfDifferentiable Z, Number N>
[[nodiscard]] Z operator*(N x, const Z& z) {
  return Z(x * z.real(), x * z.imag());
}
template <detail::ComplexOfDifferentiable Z, Number N>
[[nodiscard]] Z operator/(const Z& z, N x) {
  return Z(z.real() / x, z.imag() / x);
}
template <detail::ComplexOfDifferentiable Z, Number N>
[[nodiscard]] Z operator/(N x, const Z& z) {
  return Z(typename Z::value_type(x)) / z;
}

[[nodiscard]] auto operator-(const detail::Argument auto& x) { return detail::make_unary<detail::Negate>(x); }

template <Differentiable X>
[[nodiscard]] const X& operator+(const X& x) {
  return x;
}

/// Prints the value alone, like a plain number.
template <class Character, class Traits, Differentiable X>
std::basic_ostream<Character, Traits>& operator<<(std::basic_ostream<Character, Traits>& out, const X& x) {
  return out << detail::base_value(x);
}

/// Comparisons look at the values only.
template <class X, detail::FormulaOperands<X> Y>
[[nodiscard]] std::partial_ordering operator<=>(const X& x, const Y& y) {
  using T = detail::Base<detail::ScalarOf<X, Y>>;
  return detail::value_of<T>(x) <=> detail::value_of<T>(y);
}

// These alone need one comparison of numbers; by operator<=> they would take two.
template <class X, detail::FormulaOperands<X> Y>
[[nodiscard]] bool operator<(const X& x, const Y& y) {
  using T = detail::Base<detail::ScalarOf<X, Y>>;
  return detail::value_of<T>(x) < detail::value_of<T>(y);
}
template <class X, class Y>
requires detail::FormulaOperands<X, Y>
[[nodiscard]] bool operator>(const X& x, const Y& y) { return y < x; }

template <class X, class Y>
requires detail::FormulaOperands<X, Y>
[[nodiscard]] bool operator==(const X& x, const Y& y) { return (x <=> y) == 0; }
}  // namespace tapestry

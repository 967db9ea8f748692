#pragma once
#include <compare>
#include <iosfwd>
#include <tapestry/autodiff/detail/tape/expression.hpp>
#include <tapestry/autodiff/detail/tape/formula.hpp>

namespace tapestry {
namespace detail {
struct Plus {
  static constexpr bool is_cheap = true;
  using SlopeX = One;
  using SlopeY = One;
  template <class T>
  static T value(const T& x, const T& y) {
    return x + y;
  }
  template <class T>
  static T partial_x(const T&, const T&, const T&) {
    return T(1);
  }
  template <class T>
  static T partial_y(const T&, const T&, const T&) {
    return T(1);
  }
  /// The gradient g times the partial of one side.
  template <class T>
  static T pass_x(const T& g, const T&, const T&) {
    return g;
  }
  template <class T>
  static T pass_y(const T& g, const T&, const T&) {
    return g;
  }
};
struct Minus {
  static constexpr bool is_cheap = true;
  using SlopeX = One;
  using SlopeY = MinusOne;
  template <class T>
  static T value(const T& x, const T& y) {
    return x - y;
  }
  template <class T>
  static T partial_x(const T&, const T&, const T&) {
    return T(1);
  }
  template <class T>
  static T partial_y(const T&, const T&, const T&) {
    return T(-1);
  }
  template <class T>
  static T pass_x(const T& g, const T&, const T&) {
    return g;
  }
  template <class T>
  static T pass_y(const T& g, const T&, const T&) {
    return -g;
  }
};
struct Times {
  static constexpr bool is_cheap = true;
  static constexpr bool is_linear_in_x = true;
  static constexpr bool is_linear_in_y = true;
  template <class T>
  static T value(const T& x, const T& y) {
    return x * y;
  }
  template <class T>
  static T partial_x(const T&, const T& y, const T&) {
    return y;
  }
  template <class T>
  static T partial_y(const T& x, const T&, const T&) {
    return x;
  }
};
struct Divide {
  static constexpr bool is_cheap = true;
  static constexpr bool is_linear_in_x = true;
  static bool is_kink(const auto&, const auto& y) { return y == 0; }
  template <class T>
  static T value(const T& x, const T& y) {
    return x / y;
  }
  template <class T>
  static T partial_x(const T&, const T& y, const T&) {
    return T(1) / y;
  }
  template <class T>
  static T partial_y(const T&, const T& y, const T& quotient) {
    return -quotient / y;
  }
};
struct Negate {
  static constexpr bool is_cheap = true;
  using Slope = MinusOne;
  template <class T>
  static T value(const T& x) {
    return -x;
  }
  template <class T>
  static T partial(const T&, const T&) {
    return T(-1);
  }
};
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

namespace detail {
/// std::complex of variables or duals; it need not be included.
template <class Z>
concept ComplexOfDifferentiable = Differentiable<typename Z::value_type> && requires(const Z& z) {
  { Z(z.real(), z.imag()).real() } -> std::same_as<typename Z::value_type>;
};
}  // namespace detail

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

template <Differentiable X>
[[nodiscard]] auto operator-(const X& x) {
  return detail::make_unary<detail::Negate>(x);
}

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
template <class X, class Y>
requires detail::FormulaOperands<X, Y>
[[nodiscard]] std::partial_ordering operator<=>(const X& x, const Y& y) {
  using T = detail::Base<detail::ScalarOf<X, Y>>;
  return detail::value_of<T>(x) <=> detail::value_of<T>(y);
}

template <class X, class Y>
requires detail::FormulaOperands<X, Y>
[[nodiscard]] bool operator==(const X& x, const Y& y) { return (x <=> y) == 0; }

}  // namespace tapestry

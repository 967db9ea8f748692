#pragma once
#include <cmath>
#include <concepts>
#include <functional>

/// \file
/// Functions of two numbers, as ONNX defines them, for BinaryOperation. `by_a` and `by_b` are the
/// derivatives. VectorFunctions have neither branches nor calls, so that their
/// loops are loops of vectors.

namespace tapestry::nn::binary {
/// Functions with integer, Boolean or piecewise constant results: no derivative.
struct Discrete {
  static constexpr bool is_vector = false;
  static constexpr bool has_derivative = false;
};
/// Defaults of functions of two operands.
struct Function {
  static constexpr bool is_vector = false;
  static constexpr bool has_derivative = true;
};
/// Defaults for functions of two operands that are computed by vectors.
struct VectorFunction {
  static constexpr bool is_vector = true;
  static constexpr bool has_derivative = true;
};

/// x + y.
template <std::floating_point T>
struct Add : VectorFunction {
  [[gnu::always_inline]] static T value(T a, T b) { return a + b; }
};

/// x − y.
template <std::floating_point T>
struct Sub : VectorFunction {
  [[gnu::always_inline]] static T value(T a, T b) { return a - b; }
};

/// x · y.
template <std::floating_point T>
struct Mul : VectorFunction {
  [[gnu::always_inline]] static T value(T a, T b) { return a * b; }
};

/// x / y.
template <std::floating_point T>
struct Div : VectorFunction {
  [[gnu::always_inline]] static T value(T a, T b) { return a / b; }
  static T by_a(T, T b) { return 1 / b; }
  static T by_b(T a, T b) { return -(a / b) / b; }
};

/// Rounds towards 0; NaN where b is 0.
template <std::floating_point T>
struct IntegerDiv : Discrete {
  static T value(T a, T b) { return std::trunc(a / b); }
};

/// a^b. With respect to b, the derivative is 0 where a is not above 0.
template <std::floating_point T>
struct Pow : Function {
  static T value(T a, T b) { return b == 2 ? a * a : std::pow(a, b); }
  static T by_a(T a, T b) {
    if (b == 2) return 2 * a;
    return b == 0 ? T(0) : b * std::pow(a, b - 1);
  }
  static T by_b(T a, T b) { return a > 0 ? std::pow(a, b) * std::log(a) : T(0); }
};

/// x^y of integers.
template <std::floating_point T>
struct IntegerPow : Discrete {
  static T value(T a, T b) { return std::trunc(std::pow(a, b)); }
};

/// The remainder of the sign of a. With respect to b, the derivative is that between the jumps.
template <std::floating_point T>
struct Fmod : Function {
  static T value(T a, T b) { return std::fmod(a, b); }
  static T by_a(T, T) { return 1; }
  static T by_b(T a, T b) { return -std::trunc(a / b); }
};

/// The remainder of the sign of b.
template <std::floating_point T>
struct IntegerMod : Discrete {
  static T value(T a, T b) {
    const T rest = std::fmod(a, b);
    return rest != 0 && (rest < 0) != (b < 0) ? rest + b : rest;
  }
};

/// a above 0, a · b elsewhere; at a = 0 the derivative with respect to a is b.
template <std::floating_point T>
struct PRelu : VectorFunction {
  [[gnu::always_inline]] static T value(T a, T b) { return a > 0 ? a : a * b; }
  static T by_a(T a, T b) { return a > 0 ? T(1) : b; }
  static T by_b(T a, T) { return a > 0 ? T(0) : a; }
};

/// 1 where a relation of the standard library holds.
template <std::floating_point T, template <class> class Relation>
struct Test : Discrete {
  static T value(T a, T b) { return Relation<T>()(a, b) ? T(1) : T(0); }
};

/// 1 if exactly one is not 0.
template <std::floating_point T>
struct Xor : Discrete {
  static T value(T a, T b) { return (a != 0) != (b != 0) ? T(1) : T(0); }
};
}  // namespace tapestry::nn::binary

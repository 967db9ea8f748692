#pragma once
#include <cmath>
#include <concepts>

/// \file
/// Functions of two numbers, as ONNX defines them, for BinaryOperation. `by_a` and `by_b` are the
/// derivatives. Those that are VectorFunctions have neither branches nor calls, so that loops of them are
/// loops of vectors.

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
struct Add : VectorFunction {
  template <std::floating_point T>
  [[gnu::always_inline]] static T value(T a, T b) {
    return a + b;
  }
  template <std::floating_point T>
  static T by_a(T, T) {
    return 1;
  }
  template <std::floating_point T>
  static T by_b(T, T) {
    return 1;
  }
};

/// x − y.
struct Sub : VectorFunction {
  template <std::floating_point T>
  [[gnu::always_inline]] static T value(T a, T b) {
    return a - b;
  }
  template <std::floating_point T>
  static T by_a(T, T) {
    return 1;
  }
  template <std::floating_point T>
  static T by_b(T, T) {
    return -1;
  }
};

/// x · y.
struct Mul : VectorFunction {
  template <std::floating_point T>
  [[gnu::always_inline]] static T value(T a, T b) {
    return a * b;
  }
  template <std::floating_point T>
  static T by_a(T, T b) {
    return b;
  }
  template <std::floating_point T>
  static T by_b(T a, T) {
    return a;
  }
};

/// x / y.
struct Div : VectorFunction {
  template <std::floating_point T>
  [[gnu::always_inline]] static T value(T a, T b) {
    return a / b;
  }
  template <std::floating_point T>
  static T by_a(T, T b) {
    return 1 / b;
  }
  template <std::floating_point T>
  static T by_b(T a, T b) {
    return -(a / b) / b;
  }
};

/// Towards 0; not a number where b is 0.
struct IntegerDiv : Discrete {
  template <std::floating_point T>
  static T value(T a, T b) {
    return std::trunc(a / b);
  }
};

/// a^b. With respect to b, the derivative is 0 where a is not above 0.
struct Pow : Function {
  template <std::floating_point T>
  static T value(T a, T b) {
    return b == 2 ? a * a : std::pow(a, b);
  }
  template <std::floating_point T>
  static T by_a(T a, T b) {
    if (b == 2) return 2 * a;
    return b == 0 ? T(0) : b * std::pow(a, b - 1);
  }
  template <std::floating_point T>
  static T by_b(T a, T b) {
    return a > 0 ? std::pow(a, b) * std::log(a) : T(0);
  }
};

/// x^y of integers.
struct IntegerPow : Discrete {
  template <std::floating_point T>
  static T value(T a, T b) {
    return std::trunc(std::pow(a, b));
  }
};

/// The remainder of the sign of a. With respect to b, the derivative is that between the jumps.
struct Fmod : Function {
  template <std::floating_point T>
  static T value(T a, T b) {
    return std::fmod(a, b);
  }
  template <std::floating_point T>
  static T by_a(T, T) {
    return 1;
  }
  template <std::floating_point T>
  static T by_b(T a, T b) {
    return -std::trunc(a / b);
  }
};

/// The remainder of the sign of b.
struct IntegerMod : Discrete {
  template <std::floating_point T>
  static T value(T a, T b) {
    const T rest = std::fmod(a, b);
    return rest != 0 && (rest < 0) != (b < 0) ? rest + b : rest;
  }
};

/// a above 0, a · b elsewhere; at a = 0 the derivative with respect to a is b.
struct PRelu : VectorFunction {
  template <std::floating_point T>
  [[gnu::always_inline]] static T value(T a, T b) {
    return a > 0 ? a : a * b;
  }
  template <std::floating_point T>
  static T by_a(T a, T b) {
    return a > 0 ? T(1) : b;
  }
  template <std::floating_point T>
  static T by_b(T a, T) {
    return a > 0 ? T(0) : a;
  }
};

/// 1 if x = y.
struct Equal : Discrete {
  template <std::floating_point T>
  static T value(T a, T b) {
    return a == b ? T(1) : T(0);
  }
};

/// 1 if x > y.
struct Greater : Discrete {
  template <std::floating_point T>
  static T value(T a, T b) {
    return a > b ? T(1) : T(0);
  }
};

/// 1 if x ≥ y.
struct GreaterOrEqual : Discrete {
  template <std::floating_point T>
  static T value(T a, T b) {
    return a >= b ? T(1) : T(0);
  }
};

/// 1 if x < y.
struct Less : Discrete {
  template <std::floating_point T>
  static T value(T a, T b) {
    return a < b ? T(1) : T(0);
  }
};

/// 1 if x ≤ y.
struct LessOrEqual : Discrete {
  template <std::floating_point T>
  static T value(T a, T b) {
    return a <= b ? T(1) : T(0);
  }
};

/// 1 if both are not 0.
struct And : Discrete {
  template <std::floating_point T>
  static T value(T a, T b) {
    return a != 0 && b != 0 ? T(1) : T(0);
  }
};

/// 1 if one is not 0.
struct Or : Discrete {
  template <std::floating_point T>
  static T value(T a, T b) {
    return a != 0 || b != 0 ? T(1) : T(0);
  }
};

/// 1 if exactly one is not 0.
struct Xor : Discrete {
  template <std::floating_point T>
  static T value(T a, T b) {
    return (a != 0) != (b != 0) ? T(1) : T(0);
  }
};

}  // namespace tapestry::nn::binary

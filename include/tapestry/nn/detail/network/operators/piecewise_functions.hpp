#pragma once
#include <tapestry/nn/detail/network/operators/unary_functions.hpp>

/// \file
/// Piecewise functions of one number, under the rules of unary_functions.hpp. Each states which derivative it
/// takes at a kink.

namespace tapestry::nn::unary {
/// max(x, 0), of derivative 0 at 0.
template <std::floating_point T>
struct Relu : VectorFunction<Reads::input> {
  [[gnu::always_inline]] static T value(T x, T, T) { return x <= 0 ? T(0) : x; }
};

/// Clipped to [a, b], or b if b is below a; the derivative at both ends is 1.
template <std::floating_point T>
struct Clip : VectorFunction<Reads::input> {
  [[gnu::always_inline]] static T value(T x, T a, T b) {
    const T raised = x < a ? a : x;
    return raised > b ? b : raised;
  }
  [[gnu::always_inline]] static T slope(T x, T a, T b) { return x >= a && x <= b ? T(1) : T(0); }
};

/// a · x + b between 0 and 1, with derivative 0 at both.
template <std::floating_point T>
struct HardSigmoid : VectorFunction<Reads::input> {
  [[gnu::always_inline]] static T value(T x, T a, T b) {
    const T line = a * x + b;
    const T raised = line < 0 ? T(0) : line;
    return raised > 1 ? T(1) : raised;
  }
  [[gnu::always_inline]] static T slope(T x, T a, T b) {
    const T line = a * x + b;
    return line > 0 && line < 1 ? a : T(0);
  }
};

/// x · (x/6 + 1/2, between 0 and 1), of derivative 0 at −3 and 1 at 3.
template <std::floating_point T>
struct HardSwish : VectorFunction<Reads::input> {
  [[gnu::always_inline]] static T value(T x, T, T) {
    const T line = x * static_cast<T>(1.0 / 6) + T(0.5);
    const T raised = line < 0 ? T(0) : line;
    return x * (raised > 1 ? T(1) : raised);
  }
  [[gnu::always_inline]] static T slope(T x, T, T) {
    const T inside = x * static_cast<T>(1.0 / 3) + T(0.5);
    const T raised = x <= -3 ? T(0) : inside;
    return x >= 3 ? T(1) : raised;
  }
  [[gnu::always_inline]] static T curvature(T x, T, T) {
    return x > -3 && x < 3 ? static_cast<T>(1.0 / 3) : T(0);
  }
};

/// 0 below −2, x²/2 + x up to 0, x above; derivative 0 at −2 and 1 at 0. Tapestry's own operator, for
/// Darknet.
template <std::floating_point T>
struct HardMish : VectorFunction<Reads::input> {
  [[gnu::always_inline]] static T value(T x, T, T) {
    const T raised = x <= -2 ? T(0) : x * x / 2 + x;
    return x > 0 ? x : raised;
  }
  [[gnu::always_inline]] static T slope(T x, T, T) {
    const T inside = x <= -2 ? T(0) : x + 1;
    return x > 0 ? T(1) : inside;
  }
  [[gnu::always_inline]] static T curvature(T x, T, T) { return x > -2 && x < 0 ? T(1) : T(0); }
};

/// x above 0, a · (e^x − 1) elsewhere, of derivative a at 0.
template <std::floating_point T>
struct Elu : Function<Reads::input> {
  static T value(T x, T a, T) { return x > 0 ? x : a * std::expm1(x); }
  static T slope(T x, T a, T) { return x > 0 ? T(1) : a * std::exp(x); }
  static T curvature(T x, T a, T) { return x > 0 ? T(0) : a * std::exp(x); }
};

/// b times Elu.
template <std::floating_point T>
struct Selu : Function<Reads::input> {
  static T value(T x, T a, T b) { return b * Elu<T>::value(x, a, b); }
  static T slope(T x, T a, T b) { return b * Elu<T>::slope(x, a, b); }
  static T curvature(T x, T a, T b) { return b * Elu<T>::curvature(x, a, b); }
};

/// x above 0, a · (e^(x/a) − 1) elsewhere, of derivative 1 at 0.
template <std::floating_point T>
struct Celu : Function<Reads::input> {
  static T value(T x, T a, T) { return x > 0 ? x : a * std::expm1(x / a); }
  static T slope(T x, T a, T) { return x > 0 ? T(1) : std::exp(x / a); }
  static T curvature(T x, T a, T) { return x > 0 ? T(0) : std::exp(x / a) / a; }
};

/// x/(1 + |x|), of derivative 1 at 0.
template <std::floating_point T>
struct Softsign : Function<Reads::input> {
  static T value(T x, T, T) { return x / (1 + magnitude(x)); }
  static T slope(T x, T, T) {
    const T part = 1 / (1 + magnitude(x));
    return part * part;
  }
  static T curvature(T x, T, T) {
    const T part = 1 / (1 + magnitude(x)), size = 2 * part * part * part;
    return x > 0 ? -size : size;
  }
};

/// x above a, 0 elsewhere, of derivative 0 at a.
template <std::floating_point T>
struct ThresholdedRelu : Function<Reads::input> {
  static T value(T x, T a, T) { return x <= a ? T(0) : x; }
  static T slope(T x, T a, T) { return x > a ? T(1) : T(0); }
};

/// x + b below −a, x − b above a, 0 between, of derivative 0 at either.
template <std::floating_point T>
struct Shrink : Function<Reads::input> {
  static T value(T x, T a, T b) {
    if (x < -a) return x + b;
    if (x > a) return x - b;
    return x == x ? T(0) : x;
  }
  static T slope(T x, T a, T) { return x < -a || x > a ? T(1) : T(0); }
};

/// |x|, of derivative 0 at 0.
template <std::floating_point T>
struct Abs : Function<Reads::input> {
  static T value(T x, T, T) {
    return magnitude(x) + 0;  // of −0, too
  }
  static T slope(T x, T, T) {
    const T below = x < 0 ? T(-1) : T(0);
    return x > 0 ? T(1) : below;
  }
};

/// −x.
template <std::floating_point T>
struct Neg : Function<Reads::nothing> {
  static T value(T x, T, T) { return -x; }
  static T slope(T, T, T) { return -1; }
};

// Steps, whose derivative is 0 or not defined.

/// The largest integer not above x.
template <std::floating_point T>
struct Floor : Function<Reads::no_derivative> {
  static T value(T x, T, T) { return std::floor(x); }
};

/// The least integer not below x.
template <std::floating_point T>
struct Ceil : Function<Reads::no_derivative> {
  static T value(T x, T, T) { return std::ceil(x); }
};

/// To the nearest integer, halves to the even one.
template <std::floating_point T>
struct Round : Function<Reads::no_derivative> {
  static T value(T x, T, T) {
    const T below = std::floor(x), rest = x - below;
    if (rest != T(0.5)) return std::round(x);
    return std::fmod(below, T(2)) == 0 ? below : below + 1;
  }
};

/// Round with the derivative 1, "straight through", for quantised networks.
template <std::floating_point T>
struct StraightRound : Function<Reads::nothing> {
  static T value(T x, T, T) { return Round<T>::value(x, T(0), T(0)); }
  static T slope(T, T, T) { return 1; }
};

/// −1, 0 or 1 by the sign of x.
template <std::floating_point T>
struct Sign : Function<Reads::no_derivative> {
  static T value(T x, T, T) { return x > 0 ? T(1) : x < 0 ? T(-1) : x; }
};

/// Rounds towards 0.
template <std::floating_point T>
struct Truncate : Function<Reads::no_derivative> {
  static T value(T x, T, T) { return std::trunc(x); }
};

/// 1 unless x is 0.
template <std::floating_point T>
struct IsTrue : Function<Reads::no_derivative> {
  static T value(T x, T, T) { return x == 0 ? T(0) : T(1); }
};

/// 1 if x is 0.
template <std::floating_point T>
struct Not : Function<Reads::no_derivative> {
  static T value(T x, T, T) { return x == 0 ? T(1) : T(0); }
};

/// 1 if x is −∞ and a is not 0, or ∞ and b is not.
template <std::floating_point T>
struct IsInf : Function<Reads::no_derivative> {
  static T value(T x, T a, T b) { return std::isinf(x) && (x < 0 ? a : b) != 0 ? T(1) : T(0); }
};

/// 1 if x is NaN.
template <std::floating_point T>
struct IsNan : Function<Reads::no_derivative> {
  static T value(T x, T, T) { return x != x ? T(1) : T(0); }
};
}  // namespace tapestry::nn::unary

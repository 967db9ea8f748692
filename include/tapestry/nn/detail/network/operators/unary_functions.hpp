#pragma once
#include <tapestry/autodiff/dual.hpp>
#include <tapestry/core/vector_exp.hpp>

/// \file
/// Smooth functions of one number with at most two parameters, as ONNX defines them, for UnaryOperation.
/// `slope` is the derivative and `curvature` the second one, computed from the argument or the value, as
/// `reads` states; without a curvature of its own a function is linear between kinks. NaN stays NaN.
///
/// VectorFunctions have neither branches nor calls, so that their loops are loops of vectors. Their
/// exponentials are vector_exp(): results err by a relative 8 ε at most down to e^-86.8 in float and e^-707.5
/// in double, and are 0 below.

namespace tapestry::nn::unary {
using tapestry::detail::magnitude, tapestry::detail::vector_exp, tapestry::detail::vector_sigmoid,
    tapestry::detail::vector_sigmoid_slope;

/// Input of a function's derivative, beside its parameters.
enum class Reads { nothing, input, output, no_derivative };

/// Defaults of functions of one operand.
template <Reads From>
struct Function {
  static constexpr Reads reads = From;
  static constexpr bool is_vector = false;
  template <std::floating_point T>
  static T curvature(T, T, T) {
    return 0;
  }
};
/// Defaults for functions of one operand that are computed by vectors.
template <Reads From>
struct VectorFunction : Function<From> {
  static constexpr bool is_vector = true;
};

/// A function of the tape, see autodiff/functions.hpp.
template <std::floating_point T, class Row, Reads From = Reads::input>
struct OfTape : Function<From> {
  static T value(T x, T, T) { return Row::value(x); }
  static T slope(T from, T, T) { return Row::partial(from, from); }  // partial() reads one of the two
  static T curvature(T from, T, T) {
    if constexpr (From == Reads::output) {
      const Dual<T> y(from, {Row::partial(from, from)});
      return Row::partial(y, y).tangent();
    } else {
      const auto x = Dual<T>::input(from);
      return tapestry::detail::slope_of<Row>(x, x).tangent();
    }
  }
};

/// terms[Term] + terms[Term + 1] · r + … + terms[Last] · r^(Last − Term). Unrolled, so that loops around it
/// become loops of vectors.
template <std::size_t Term, std::size_t Last, class T, std::size_t Count>
[[nodiscard, gnu::always_inline]] inline T polynomial(const double (&terms)[Count], T r) {
  if constexpr (Term == Last) {
    return static_cast<T>(terms[Term]);
  } else {
    return polynomial<Term + 1, Last>(terms, r) * r + static_cast<T>(terms[Term]);
  }
}

/// σ(x) = 1 / (1 + e^−x).
template <std::floating_point T>
struct Sigmoid : VectorFunction<Reads::input> {
  [[gnu::always_inline]] static T value(T x, T, T) { return vector_sigmoid(x); }
  [[gnu::always_inline]] static T slope(T x, T, T) { return vector_sigmoid_slope(x); }
  [[gnu::always_inline]] static T curvature(T x, T, T) {
    const T e = vector_exp(-magnitude(x)), size = e * (1 - e) / ((1 + e) * (1 + e) * (1 + e));
    return x < 0 ? size : -size;
  }
};

/// x · σ(a · x); a is 1 for the function that is also called SiLU.
template <std::floating_point T>
struct Swish : VectorFunction<Reads::input> {
  [[gnu::always_inline]] static T value(T x, T a, T) { return x * vector_sigmoid(a * x); }
  [[gnu::always_inline]] static T slope(T x, T a, T) {
    return vector_sigmoid(a * x) + a * x * vector_sigmoid_slope(a * x);
  }
  [[gnu::always_inline]] static T curvature(T x, T a, T) {
    return a * (2 * vector_sigmoid_slope(a * x) + a * x * Sigmoid<T>::curvature(a * x, a, a));
  }
};

/// x · tanh(log(1 + e^x)) = x · n/(n + 2) with n = e^x · (e^x + 2); beyond 20 it is x to double precision.
template <std::floating_point T>
struct Mish : VectorFunction<Reads::input> {
  [[gnu::always_inline]] static T value(T x, T, T) {
    const T e = vector_exp(x > 20 ? T(20) : x);
    const T n = e * (e + 2);
    return x > 20 ? x : x * (n / (n + 2));
  }
  [[gnu::always_inline]] static T slope(T x, T, T) {
    const T e = vector_exp(x > 20 ? T(20) : x);
    const T n = e * (e + 2);
    // 1 − tanh² = (4n + 4)/(n + 2)², and the derivative of log(1 + e^x) is e^x/(1 + e^x)
    const T below = n / (n + 2) + x * (e / (1 + e)) * ((4 * n + 4) / ((n + 2) * (n + 2)));
    return x > 20 ? T(1) : below;
  }
  [[gnu::always_inline]] static T curvature(T x, T, T) {
    const T e = vector_exp(x > 20 ? T(20) : x), part = e / (1 + e);
    const T n = e * (e + 2), rest = (4 * n + 4) / ((n + 2) * (n + 2));
    const T below = part * rest * (2 + x * (1 / (1 + e) - 2 * part * (n / (n + 2))));
    return x > 20 ? T(0) : below;
  }
};

/// e^x.
template <std::floating_point T>
struct Exp : VectorFunction<Reads::output> {
  [[gnu::always_inline]] static T value(T x, T, T) { return vector_exp(x); }
  [[gnu::always_inline]] static T slope(T y, T, T) { return y; }
  [[gnu::always_inline]] static T curvature(T y, T, T) { return y; }
};

/// (1 − e)/(1 + e) with e = exp(−2|x|); below 1/4 its series, to x^19 in double.
template <std::floating_point T>
struct Tanh : VectorFunction<Reads::input> {
  static constexpr double terms[] = {-1.0 / 3,
                                     2.0 / 15,
                                     -17.0 / 315,
                                     62.0 / 2835,
                                     -1382.0 / 155925,
                                     21844.0 / 6081075,
                                     -929569.0 / 638512875,
                                     6404582.0 / 10854718875,
                                     -443861162.0 / 1856156927625};
  [[gnu::always_inline]] static T value(T x, T, T) {
    const T size = magnitude(x), square = x * x, e = vector_exp(-2 * size);
    constexpr std::size_t last = sizeof(T) == 4 ? 4 : 8;
    const T near = x + x * square * polynomial<0, last>(terms, square);
    const T far = (1 - e) / (1 + e);
    const T signed_far = x < 0 ? -far : far;
    return size < T(0.25) ? near : signed_far;
  }
  [[gnu::always_inline]] static T slope(T x, T, T) { return 4 * vector_sigmoid_slope(2 * x); }
  [[gnu::always_inline]] static T curvature(T x, T a, T) { return 8 * Sigmoid<T>::curvature(2 * x, a, a); }
};

/// log(1 + e^x) = max(x, 0) + log(1 + e^−|x|), where log(1 + e) = 2 artanh s with s = e/(2 + e), by its
/// series: s is at most 1/3.
template <std::floating_point T>
struct Softplus : VectorFunction<Reads::input> {
  static constexpr double terms[] = {1.0 / 3,  1.0 / 5,  1.0 / 7,  1.0 / 9,  1.0 / 11, 1.0 / 13,
                                     1.0 / 15, 1.0 / 17, 1.0 / 19, 1.0 / 21, 1.0 / 23, 1.0 / 25,
                                     1.0 / 27, 1.0 / 29, 1.0 / 31, 1.0 / 33};
  [[gnu::always_inline]] static T value(T x, T, T) {
    const T e = vector_exp(-magnitude(x)), s = e / (2 + e), square = s * s;
    constexpr std::size_t last = sizeof(T) == 4 ? 6 : 15;
    const T logarithm = 2 * (s + s * square * polynomial<0, last>(terms, square));
    return (x < 0 ? T(0) : x) + logarithm;
  }
  [[gnu::always_inline]] static T slope(T x, T, T) { return vector_sigmoid(x); }
  [[gnu::always_inline]] static T curvature(T x, T, T) { return vector_sigmoid_slope(x); }
};

/// x · Φ(x) with Φ the normal distribution.
template <std::floating_point T>
struct Gelu : Function<Reads::input> {
  static T normal(T x) { return std::erfc(x * static_cast<T>(-0.70710678118654752)) / 2; }
  static T value(T x, T, T) { return x * normal(x); }
  static T slope(T x, T, T) {
    return normal(x) + x * (static_cast<T>(0.39894228040143268) * std::exp(-x * x / 2));
  }
  static T curvature(T x, T, T) {
    const T density = static_cast<T>(0.39894228040143268) * std::exp(-x * x / 2);
    return density == 0 ? T(0) : density * (2 - x * x);
  }
};

/// x/2 · (1 + tanh u) = x · σ(2u) with u = √(2/π) · (x + 0.044715 x³); beyond 10 the slope is the limit's, 1
/// or 0, to double precision.
template <std::floating_point T>
struct GeluTanh : Function<Reads::input> {
  static T twice_u(T x) {
    return static_cast<T>(1.5957691216057308) * x * (1 + static_cast<T>(0.044715) * x * x);
  }
  static T value(T x, T, T) { return x * vector_sigmoid(twice_u(x)); }
  static T slope(T x, T, T) {
    if (magnitude(x) > 10) return x > 0 ? T(1) : T(0);
    const T inner = static_cast<T>(1.5957691216057308) * (1 + static_cast<T>(0.134145) * x * x);
    return vector_sigmoid(twice_u(x)) + x * inner * vector_sigmoid_slope(twice_u(x));
  }
  static T curvature(T x, T a, T b) {
    if (magnitude(x) > 10) return 0;
    const T inner = static_cast<T>(1.5957691216057308) * (1 + static_cast<T>(0.134145) * x * x);
    const T bend = static_cast<T>(2 * 1.5957691216057308 * 0.134145) * x;
    return (2 * inner + x * bend) * vector_sigmoid_slope(twice_u(x)) +
           x * inner * inner * Sigmoid<T>::curvature(twice_u(x), a, b);
  }
};

/// 2/√π · ∫ e^(−t²) from 0 to x.
template <std::floating_point T>
struct Erf : Function<Reads::input> {
  static T value(T x, T, T) { return std::erf(x); }
  static T slope(T x, T, T) {
    return static_cast<T>(1.1283791670955126) * std::exp(-x * x);  // 2/√π
  }
  static T curvature(T x, T a, T b) {
    const T own = slope(x, a, b);
    return own == 0 ? T(0) : -2 * x * own;
  }
};

/// arctan x.
template <std::floating_point T>
struct Atan : Function<Reads::input> {
  static T value(T x, T, T) { return std::atan(x); }
  static T slope(T x, T, T) { return 1 / (1 + x * x); }
  static T curvature(T x, T, T) {
    const T part = 1 / (1 + x * x);
    return -2 * x * part * part;
  }
};

/// 1 / x.
template <std::floating_point T>
struct Reciprocal : Function<Reads::output> {
  static T value(T x, T, T) { return 1 / x; }
  static T slope(T y, T, T) { return -y * y; }
  static T curvature(T y, T, T) { return 2 * y * y * y; }
};
}  // namespace tapestry::nn::unary

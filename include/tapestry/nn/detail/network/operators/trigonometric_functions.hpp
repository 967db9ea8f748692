#pragma once
#include <tapestry/nn/detail/network/operators/unary_functions.hpp>

/// \file
/// Circular and hyperbolic functions and their inverses, under the rules of unary_functions.hpp. The slope is
/// infinite where the derivative is: at the ends of an inverse's range.

namespace tapestry::nn::unary {

/// sin x.
struct Sin : Function<Reads::input> {
  template <std::floating_point T>
  static T value(T x, T, T) {
    return std::sin(x);
  }
  template <std::floating_point T>
  static T slope(T x, T, T) {
    return std::cos(x);
  }
};

/// cos x.
struct Cos : Function<Reads::input> {
  template <std::floating_point T>
  static T value(T x, T, T) {
    return std::cos(x);
  }
  template <std::floating_point T>
  static T slope(T x, T, T) {
    return -std::sin(x);
  }
};

/// arctan x.
struct Atan : Function<Reads::input> {
  template <std::floating_point T>
  static T value(T x, T, T) {
    return std::atan(x);
  }
  template <std::floating_point T>
  static T slope(T x, T, T) {
    return 1 / (1 + x * x);
  }
};

/// tan x.
struct Tan : Function<Reads::output> {
  template <std::floating_point T>
  static T value(T x, T, T) {
    return std::tan(x);
  }
  template <std::floating_point T>
  static T slope(T y, T, T) {
    return 1 + y * y;
  }
};

/// arcsin x.
struct Asin : Function<Reads::input> {
  template <std::floating_point T>
  static T value(T x, T, T) {
    return std::asin(x);
  }
  template <std::floating_point T>
  static T slope(T x, T, T) {
    return 1 / std::sqrt((1 - x) * (1 + x));
  }
};

/// arccos x.
struct Acos : Function<Reads::input> {
  template <std::floating_point T>
  static T value(T x, T, T) {
    return std::acos(x);
  }
  template <std::floating_point T>
  static T slope(T x, T, T) {
    return -1 / std::sqrt((1 - x) * (1 + x));
  }
};

/// sinh x.
struct Sinh : Function<Reads::input> {
  template <std::floating_point T>
  static T value(T x, T, T) {
    return std::sinh(x);
  }
  template <std::floating_point T>
  static T slope(T x, T, T) {
    return std::cosh(x);
  }
};

/// cosh x.
struct Cosh : Function<Reads::input> {
  template <std::floating_point T>
  static T value(T x, T, T) {
    return std::cosh(x);
  }
  template <std::floating_point T>
  static T slope(T x, T, T) {
    return std::sinh(x);
  }
};

/// arsinh x.
struct Asinh : Function<Reads::input> {
  template <std::floating_point T>
  static T value(T x, T, T) {
    return std::asinh(x);
  }
  template <std::floating_point T>
  static T slope(T x, T, T) {
    return 1 / std::hypot(T(1), x);
  }
};

/// arcosh x.
struct Acosh : Function<Reads::input> {
  template <std::floating_point T>
  static T value(T x, T, T) {
    return std::acosh(x);
  }
  template <std::floating_point T>
  static T slope(T x, T, T) {
    return 1 / (std::sqrt(x - 1) * std::sqrt(x + 1));
  }
};

/// artanh x.
struct Atanh : Function<Reads::input> {
  template <std::floating_point T>
  static T value(T x, T, T) {
    return std::atanh(x);
  }
  template <std::floating_point T>
  static T slope(T x, T, T) {
    return 1 / ((1 - x) * (1 + x));
  }
};

}  // namespace tapestry::nn::unary

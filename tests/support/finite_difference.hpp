#pragma once
#include <algorithm>
#include <cmath>
#include <cstddef>
#include <limits>
#include <vector>

namespace tapestry::test {
/// Step h = ε^(1/3) of a central difference at arguments of order one.
template <class Scalar>
Scalar central_difference_step() {
  return std::cbrt(std::numeric_limits<Scalar>::epsilon());
}

/// Σ aᵢ·bᵢ, summed in double.
template <class Array>
auto dot(const Array& a, const Array& b) {
  double sum = 0;
  for (std::size_t i = 0; i < a.size(); ++i)
    sum += static_cast<double>(a.data()[i]) * static_cast<double>(b.data()[i]);
  return static_cast<typename Array::value_type>(sum);
}

/// The sum of dot() over arrays of all heads.
template <class Array>
requires requires { typename Array::value_type; }
auto dot(const std::vector<Array>& a, const std::vector<Array>& b) {
  typename Array::value_type sum = 0;
  for (std::size_t h = 0; h < b.size(); ++h) sum += dot(a[h], b[h]);
  return sum;
}

/// (f(x + h·v) − f(x − h·v)) / 2h
template <class Function, class Array>
auto central_difference(Function f, const Array& x, const Array& v) {
  const auto h = central_difference_step<typename Array::value_type>();
  Array ahead = x, behind = x;
  for (std::size_t i = 0; i < x.size(); ++i) {
    ahead.data()[i] += h * v.data()[i];
    behind.data()[i] -= h * v.data()[i];
  }
  return (f(ahead) - f(behind)) / (2 * h);
}

/// (f() with `number` raised by h − f() with it lowered by h) / 2h. The number keeps its value.
template <class Scalar, class Function>
auto slope_by(Scalar& number, Scalar h, Function f) {
  const Scalar here = number;
  number = here + h;
  const auto ahead = f();
  number = here - h;
  const auto behind = f();
  number = here;
  return (ahead - behind) / (2 * h);
}

/// The derivative of f at 0 by differences of fourth order.
template <class Function>
double fourth_order_difference(Function f, double h) {
  return (8 * (f(h) - f(-h)) - (f(2 * h) - f(-2 * h))) / (12 * h);
}

/// Bound 4·ε^(2/3)·max(1, |f|) on the error of central_difference().
template <class Scalar>
Scalar central_difference_tolerance(Scalar value) {
  const auto h = central_difference_step<Scalar>();
  return 4 * h * h * std::max(Scalar(1), std::abs(value));
}
}  // namespace tapestry::test

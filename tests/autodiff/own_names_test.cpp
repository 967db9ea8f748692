#include <tapestry/autodiff.hpp>
#include <tapestry/autodiff/array_functions.hpp>

#include "../support/catch.hpp"

// A user's templates, named like functions of ours that <cmath> does not have, and called with an explicit
// argument. Each returns another value than ours.

using tapestry::Dual, tapestry::Tape, tapestry::Variable;

namespace by_value {
template <class T>
T digamma(T x) {
  return 2 * x;
}
template <class T>
T exp10(T x) {
  return 3 * x;
}
template <class T>
T passive(T x) {
  return 4 * x;
}
template <class T>
T sigmoid(T x) {
  return 5 * x;
}
template <class T>
T sign(T x) {
  return 6 * x;
}
template <class T>
T softplus(T x) {
  return 7 * x;
}
template <class T>
T square(T x) {
  return 8 * x;
}
template <class T>
T logsumexp(T x, T y) {
  return 9 * x + y;
}
template <class T>
T max(T x, T y) {
  return 10 * x + y;
}
template <class T>
T min(T x, T y) {
  return 11 * x + y;
}
template <class T>
T clamp(T x, T low, T high) {
  return 12 * x + low + high;
}

/// Σ of all with arguments that are scalars, and that are formulas of them.
template <class T>
T all(const T& a, const T& b) {
  const T of_scalars = digamma<T>(a) + exp10<T>(a) + passive<T>(a) + sigmoid<T>(a) + sign<T>(a) +
                       softplus<T>(a) + square<T>(a) + logsumexp<T>(a, b) + max<T>(a, b) + min<T>(a, b) +
                       clamp<T>(a, b, b) + max<T>(a, 0.0) + min<T>(0.0, a) + logsumexp<T>(a, 0.0) +
                       clamp<T>(a, 0.0, 0.0);
  const T of_formulas = digamma<T>(a * b + 1) + exp10<T>(a * b + 1) + passive<T>(a * b + 1) +
                        sigmoid<T>(a * b + 1) + sign<T>(a * b + 1) + softplus<T>(a * b + 1) +
                        square<T>(a * b + 1) + logsumexp<T>(a * b + 1, b) + logsumexp<T>(b, a * b + 1) +
                        max<T>(a * b + 1, b) + max<T>(b, a * b + 1) + min<T>(a * b + 1, b) +
                        min<T>(b, a * b + 1) + clamp<T>(a * b + 1, 0.0, b * b);
  return of_scalars + of_formulas;
}
}  // namespace by_value

namespace by_reference {
template <class T>
T sigmoid(const T& x) {
  return 5 * x;
}
template <class T>
T max(const T& x, const T& y) {
  return 10 * x + y;
}
template <class T>
T sum(const std::vector<T>& x) {
  return 100 * x[0];
}
template <class T>
T norm(const std::vector<T>& x) {
  return 200 * x[0];
}
template <class T>
T dot(const std::vector<T>& x, const std::vector<T>& y) {
  return 300 * x[0] * y[0];
}
template <class T>
T all(const T& a, const T& b) {
  return sigmoid<T>(a) + sigmoid<T>(a * b) + max<T>(a, b) + max<T>(a * b, b) + max<T>(b, a * b) +
         sum<T>({a, b}) + norm<T>({a, b}) + dot<T>({a, b}, {b, a});
}
}  // namespace by_reference

namespace {
// d by a, d by b, worked out from the factors above: u = ab + 1.
template <class Function>
void check(const Function& f, double a, double b, double value, double by_a, double by_b) {
  Tape<double> tape;
  const auto scope = tape.activate();
  const Variable<double> x = tape.input(a), y = tape.input(b);
  const Variable<double> root = f(x, y);
  tape.reverse(root);
  CHECK(root.value() == value);
  CHECK(x.adjoint() == by_a);
  CHECK(y.adjoint() == by_b);
  using D = Dual<double, 2>;
  const D dual = f(D::input(a, 0), D::input(b, 1));
  CHECK(dual.value() == value);
  CHECK(dual.tangents() == std::array{by_a, by_b});
  CHECK(f(a, b) == value);
}
}  // namespace

TEST_CASE("a user's template called with an explicit argument is called, not ours of its name",
          "[autodiff][own_names]") {
  // Scalars: 35 a + (9 + 10 + 11 + 12) a + 5 b + (10 + 1 + 9 + 12) a. Formulas: (35 + 9 + 1 + 10 + 1 + 11 + 1
  // + 12) u = 80 u, and b (1 + 9 + 1 + 10 + 1 + 11) + b².
  check([](const auto& a, const auto& b) { return by_value::all(a, b); }, 2, 3,
        109 * 2 + 5 * 3 + 80 * 7 + 33 * 3 + 9, 109 + 80 * 3, 5 + 80 * 2 + 33 + 6);
  check([](const auto& a, const auto& b) { return by_reference::all(a, b); }, 2, 3,
        5 * 2 + 5 * 6 + 23 + 63 + 36 + 200 + 400 + 1800, 5 + 15 + 10 + 30 + 3 + 300 + 900,
        10 + 1 + 20 + 1 + 10 + 2 + 600);
}

TEST_CASE("our functions of these names are found without an explicit argument", "[autodiff][own_names]") {
  const auto f = [](const auto& a, const auto& b) {
    return sigmoid(a * 0) + softplus(a * 0) - softplus(b * 0) + square(a) + max(a, b) + min(a, 1.0) +
           clamp(b, 0.0, 5.0) + exp10(a * 0) + sign(a) + logsumexp(a, a) - logsumexp(a * 1, a) + digamma(b) -
           digamma(b * 1) + passive(a * b);
  };
  Tape<double> tape;
  const auto scope = tape.activate();
  const Variable<double> x = tape.input(2.0), y = tape.input(3.0);
  const Variable<double> root = f(x, y);
  CHECK(root.value() == 0.5 + 4 + 3 + 1 + 3 + 1 + 1 + 6);
  tape.reverse(root);
  CHECK(x.adjoint() == 4);
  CHECK(y.adjoint() == 2);
}

#include <tapestry/autodiff/dual.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"

using tapestry::Dual, tapestry::Variable, tapestry::test::ActiveTape;

namespace {
constexpr double infinity = std::numeric_limits<double>::infinity();
struct First {};
struct Second {};

/// Every function once; on the tape and with duals the same code.
template <class S>
S of_all_functions(const S& x, const S& y) {
  S total = x + y - x * y / (x + 1.5) + 2 / y - (-x);
  total += exp(x) + exp2(x) + expm1(x) + log(x) + log2(x) + log10(x) + log1p(x) + sigmoid(x) + softplus(x);
  total += sin(x) + cos(x) + tan(x) + asin(x / 4) + acos(x / 4) + atan(x) + sinh(x) + cosh(x) + tanh(x);
  total += asinh(x) + acosh(x + 1) + atanh(x / 4) + square(x) + sqrt(x) + cbrt(x) + erf(x) + erfc(x);
  total += tgamma(x) + lgamma(x) + digamma(x) + abs(x - 3) + clamp(x, 0, 1) + polygamma<2>(x);
  total +=
      pow(x, y) + pow(x, 2.5) + pow(2, y) + hypot(x, y) + hypot(x, y, x * y) + atan2(y, x) + fma(x, y, 1.0);
  total +=
      fmod(y, x) + remainder(y, x) + max(x, y) + min(x, y) + fdim(y, x) + copysign(x, -y) + logsumexp(x, y);
  return total;
}
template <class D, class E>
concept Addable = requires(D d, E e) {
  d + e;
};
}  // namespace

TEST_CASE("duals and the tape agree on every function", "[autodiff][dual]") {
  for (const auto& [x0, y0] : {std::array{0.7, 1.9}, std::array{1.3, 0.4}, std::array{2.25, 3.5}}) {
    ActiveTape<double> tape;
    const Variable<double> x = tape.input(x0), y = tape.input(y0);
    const Variable<double> expected = of_all_functions(x, y);
    tape.reverse(expected);
    using D = Dual<double, 2>;
    const D found = of_all_functions(D::input(x0, 0), D::input(y0, 1));
    CHECK(found.value() == expected.value());
    CHECK(std::abs(found.tangent(0) - x.adjoint()) <= 1e-13 * std::abs(x.adjoint()));
    CHECK(std::abs(found.tangent(1) - y.adjoint()) <= 1e-13 * std::abs(y.adjoint()));
  }
}

TEST_CASE("second derivatives of every function agree with differences of first ones", "[autodiff][dual]") {
  using D = Dual<double>;
  using DD = Dual<D>;
  const auto slope = [](double x, double y) { return of_all_functions(D::input(x), D(y)).tangent(); };
  for (const auto& point : {std::array{0.7, 1.9}, std::array{1.3, 0.4}, std::array{2.25, 3.5}}) {
    const double x = point[0], y = point[1];
    const DD by_xx = of_all_functions(DD::input(D::input(x)), DD(y));
    const DD by_xy = of_all_functions(DD::input(D(x)), DD(D::input(y)));
    const double h = 0x1p-12;  // extrapolated: error about h⁴·f⁽⁵⁾/480 + ε·f′/h
    const auto difference = [&](double dx, double dy) {
      const auto quotient = [&](double s) {
        return (slope(x + s * dx, y + s * dy) - slope(x - s * dx, y - s * dy)) / (2 * s);
      };
      return (4 * quotient(h / 2) - quotient(h)) / 3;
    };
    CHECK(std::abs(by_xx.tangent().tangent() - difference(1, 0)) <= 1e-9 * std::abs(difference(1, 0)));
    CHECK(std::abs(by_xy.tangent().tangent() - difference(0, 1)) <= 1e-9 * std::abs(difference(1, 0)));
  }
}

TEST_CASE("third derivatives by duals of duals of duals", "[autodiff][dual]") {
  using D1 = Dual<double>;
  using D2 = Dual<D1>;
  using D3 = Dual<D2>;
  const D3 x = D3::input(D2::input(D1::input(0.5)));
  CHECK(std::abs(sin(x).tangent().tangent().tangent() + std::cos(0.5)) <= 1e-15);
  CHECK(std::abs(pow(x, 3).tangent().tangent().tangent() - 6) <= 1e-14);
}

TEST_CASE("directions of different derivatives do not mix", "[autodiff][dual]") {
  using Outer = Dual<double, 1, First>;
  using Inner = Dual<double, 1, Second>;
  STATIC_REQUIRE_FALSE(Addable<Outer, Inner>);
  STATIC_REQUIRE_FALSE(Addable<Outer, Dual<double, 2, First>>);
  STATIC_REQUIRE(Addable<Outer, Dual<Outer, 1, Second>>);
  STATIC_REQUIRE_FALSE(Addable<Variable<double>, Outer>);
  // d/dx (x · d/dy (x + y)) = 1: a confused dual would return 2.
  const Outer x = Outer::input(3.0);
  using Nested = Dual<Outer, 1, Second>;
  const Outer inner = (x + Nested::input(Outer(1.0))).tangent();
  CHECK((x * inner).tangent() == 1);
}

TEST_CASE("a zero tangent passes no infinite partial on", "[autodiff][dual]") {
  using D = Dual<double, 2>;
  const D root = sqrt(D::input(0.0, 0));
  CHECK(root.tangents() == std::array<double, 2>{infinity, 0});
  CHECK((D(0.0) * log(D(0.0))).tangents() == std::array<double, 2>{0, 0});
  CHECK(max(D::input(1.0, 0), log(D::input(0.0, 1))).tangents() == std::array<double, 2>{1, 0});
}

TEST_CASE("comparisons and conversions of duals", "[autodiff][dual]") {
  using D = Dual<double>;
  const D x = D::input(2.0);
  CHECK(x == 2);
  CHECK(x < D(3.0));
  CHECK(1 < x);
  CHECK(Dual<D>(x) == x);
  CHECK(passive(x).tangent() == 0);
  CHECK_FALSE(D(0.0, {1.0}).is_zero());
  CHECK(D(0.0).is_zero());
  D y = x;
  y += 1;
  y *= x;
  y -= x;
  y /= 2.0F;
  CHECK(y.value() == 2);
  CHECK(y.tangent() == 2);  // d/dx ((x + 1)·x − x)/2 = x
  STATIC_REQUIRE(std::same_as<decltype(floor(x)), double>);
}

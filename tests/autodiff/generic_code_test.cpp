#include <tapestry/autodiff.hpp>
#include <tapestry/autodiff/jacobian.hpp>
#include <tapestry/autodiff/record.hpp>

#include <sstream>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"

// Generic code written for numbers, run with variables, duals and formulas.

using tapestry::Dual, tapestry::Variable, tapestry::test::ActiveTape;

namespace {
constexpr double infinity = std::numeric_limits<double>::infinity();
const double not_a_number = std::numeric_limits<double>::quiet_NaN();

struct Result {
  double value, by_x, by_y;
  bool operator==(const Result&) const = default;
};

/// f(x, y) and its slopes, which the tape and duals must agree on.
template <class Function>
Result at(const Function& f, double x, double y) {
  ActiveTape<double> tape;
  const Variable<double> a = tape.input(x), b = tape.input(y);
  const Variable<double> root = f(a, b);
  tape.reverse(root);
  using D = Dual<double, 2>;
  const D dual = f(D::input(x, 0), D::input(y, 1));
  CHECK(std::array{a.adjoint(), b.adjoint()} == dual.tangents());
  CHECK((root.value() == dual.value() || (isnan(root) && isnan(dual))));
  return {root.value(), a.adjoint(), b.adjoint()};
}

template <class X>
std::string printed(const X& x) {
  std::ostringstream out;
  out << x;
  return out.str();
}
}  // namespace

TEST_CASE("fmax and fmin take the number where the other is not one", "[autodiff][generic]") {
  const auto larger = [](auto x, auto y) { return fmax(x, y); };
  const auto smaller = [](auto x, auto y) { return fmin(x, y); };
  CHECK(at(larger, 1, 2) == Result{2, 0, 1});
  CHECK(at(smaller, 1, 2) == Result{1, 1, 0});
  CHECK(at(larger, 2, 2) == Result{2, 0.5, 0.5});
  CHECK(at(smaller, 2, 2) == Result{2, 0.5, 0.5});
  CHECK(at(larger, not_a_number, 1) == Result{1, 0, 1});
  CHECK(at(larger, 1, not_a_number) == Result{1, 1, 0});
  CHECK(at(smaller, not_a_number, 1) == Result{1, 0, 1});
  CHECK(at(smaller, 1, not_a_number) == Result{1, 1, 0});
  CHECK(std::isnan(at(larger, not_a_number, not_a_number).value));
  CHECK(at([](auto x, auto) { return fmax(x * x, 1); }, 3, 0) == Result{9, 6, 0});
}

TEST_CASE("ldexp and frexp scale by powers of two, and their slopes with them", "[autodiff][generic]") {
  CHECK(at([](auto x, auto) { return ldexp(x, 3); }, 5, 0) == Result{40, 8, 0});
  CHECK(at([](auto x, auto y) { return ldexp(x * y, -1); }, 5, 3) == Result{7.5, 1.5, 2.5});
  CHECK(at([](auto x, auto) { return ldexp(x, 1100); }, 0x1p-1070, 0) == Result{0x1p30, infinity, 0});
  CHECK(at([](auto x, auto) { return ldexp(x, -1074); }, 1.5, 0).value ==
        0x1p-1073);  // rounded once, to even
  int exponent = 7;
  const auto fraction = [&](auto x, auto) { return frexp(x, &exponent); };
  CHECK(at(fraction, 40, 0) == Result{0.625, 0x1p-6, 0});
  CHECK(exponent == 6);
  CHECK(at(fraction, 0, 0) == Result{0, 1, 0});
  CHECK(exponent == 0);
  CHECK(at(fraction, -infinity, 0) == Result{-infinity, 1, 0});
  CHECK(exponent == 0);
}

TEST_CASE("lerp, exp10 and nearbyint", "[autodiff][generic]") {
  CHECK(at([](auto x, auto y) { return lerp(x, y, 0.25); }, 1, 5) == Result{2, 0.75, 0.25});
  CHECK(at([](auto x, auto t) { return lerp(x, 5, t); }, 1, 0.25) == Result{2, 0.75, 4});
  CHECK(at([](auto x, auto t) { return lerp(0.1, x, t); }, 0.7, 1).value == 0.7);
  CHECK(at([](auto x, auto) { return exp10(x); }, 2, 0) == Result{100, 100 * std::numbers::ln10, 0});
  CHECK(nearbyint(Variable<double>(2.5)) == 2);
  STATIC_REQUIRE(std::same_as<decltype(nearbyint(Dual<float>(2.5F))), float>);
}

TEST_CASE("variables and duals count, and are swapped", "[autodiff][generic]") {
  const auto counted = [](auto x, auto y) {
    swap(x, y);
    const auto before = x++;
    auto behind = y--;
    ++behind;
    --x;
    return decltype(x)(x * y + before * behind);
  };
  // y·(x − 1) + y·(x + 1) = 2·x·y
  CHECK(at(counted, 3, 5) == Result{30, 10, 6});
}

TEST_CASE("variables, duals and formulas print as their values", "[autodiff][generic]") {
  const Variable<double> x = 1.5;
  CHECK(printed(x) == "1.5");
  CHECK(printed(x * x + 1) == "3.25");
  CHECK(printed(Dual<double, 3>::input(2.5, 1)) == "2.5");
  CHECK(printed(Dual<Dual<float>>(0.5F)) == "0.5");
  CHECK(printed(Variable<Dual<double>>(-2.0)) == "-2");
}

TEST_CASE("a gradient is taken at numbers in braces", "[autodiff][generic]") {
  const auto f = [](auto v) { return v[0] * v[1] * v[1]; };
  CHECK(tapestry::gradient(f, {2, 3}).gradient == std::vector<double>{9, 12});
  CHECK(tapestry::gradient<float>(f, {2.0F, 3.0F}).gradient == std::vector<float>{9, 12});
  CHECK(tapestry::gradient(f, std::array{2.0, 3.0}).value == 18);
  CHECK(tapestry::hessian(f, {2., 3.}) == std::vector<double>{0, 6, 6, 4});
  CHECK(tapestry::hessian_product(f, {2., 3.}, {1., 0.}).product == std::vector<double>{0, 6});
  const auto both = [](auto v) { return std::array{v[0] * v[1], v[0] + v[1]}; };
  CHECK(tapestry::forward_jacobian(both, {2., 3.}) == std::vector<double>{3, 2, 1, 1});
}

TEST_CASE("a Jacobian and a recorded operation know their scalar type by the tape and the value",
          "[autodiff][generic]") {
  ActiveTape<float> tape;
  const std::vector<Variable<float>> x = {tape.input(2), tape.input(3)};
  const float product = x[0].value() * x[1].value();
  const std::array<Variable<float>, 2> y = {
      tapestry::record_scalar(
          product,
          [a = x[0].value(), b = x[1].value()](float adjoint, float* by_a, float* by_b) {
            *by_a += adjoint * b;
            *by_b += adjoint * a;
          },
          x[0], x[1]),
      x[0] + x[1]};
  CHECK(tapestry::jacobian(tape, y, x) == std::vector<float>{3, 2, 1, 1});
}

#include <tapestry/autodiff.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"
#include "function_rows.hpp"

using tapestry::Dual, tapestry::Variable, tapestry::test::ActiveTape, tapestry::test::ulps,
    tapestry::test::Wide;

// Derivatives of derivatives where a formula of the first one may have a branch, a kink or a 0 / 0 of its
// own: at ties, at zeros, and where an implementation changes its formula.

namespace {
using First = Dual<double>;
using Second = Dual<First>;
using Third = Dual<Second>;
using Series = std::array<double, 4>;  // f, f′, f″, f‴
constexpr double ln2 = std::numbers::ln2;
const double root3 = std::sqrt(3.0);

Series of_duals(const Third& y) {
  return {y.value().value().value(), y.tangent().value().value(), y.tangent().tangent().value(),
          y.tangent().tangent().tangent()};
}

template <class Function>
Series in_forward_mode(const Function& f, double x) {
  return of_duals(f(Third::input(Second::input(First::input(x)))));
}

template <class Function>
Series in_reverse_mode(const Function& f, double x) {
  ActiveTape<Second> tape;
  const Variable<Second> input = tape.input(Second::input(First::input(x)));
  const Variable<Second> y = f(input);
  tape.reverse(y);
  const Second slope = input.adjoint();
  return {y.value().value().value(), slope.value().value(), slope.tangent().value(),
          slope.tangent().tangent()};
}

constexpr double unknown = std::numeric_limits<double>::quiet_NaN();  ///< at a kink, see kinks_test.cpp

/// Equal within a few roundings of each number, or of the largest number where it is 0.
bool agrees(const Series& found, const Series& expected) {
  for (std::size_t k = 0; k < found.size(); ++k) {
    const double size = expected[k] == 0 ? 1 : std::abs(expected[k]);
    const bool is_unknown = std::isnan(found[k]) && std::isnan(expected[k]);
    if (!(std::abs(found[k] - expected[k]) <= 4e-15 * size) && found[k] != expected[k] && !is_unknown)
      return false;
  }
  return true;
}

template <class Function>
void check(const char* name, const Function& f, double x, const Series& expected) {
  const Series forward = in_forward_mode(f, x), reverse = in_reverse_mode(f, x);
  INFO(name << " at " << x << ": " << forward[0] << ' ' << forward[1] << ' ' << forward[2] << ' '
            << forward[3]);
  CHECK(agrees(forward, expected));
  CHECK(agrees(reverse, expected));
}

/// f_xx, f_xy, f_yx, f_yy.
template <class Function>
std::vector<double> hessian_at(const Function& f, double x, double y) {
  return tapestry::hessian([&](auto v) { return f(v[0], v[1]); }, std::array{x, y});
}

template <class Function>
void check_hessian(const char* name, const Function& f, double x, double y,
                   const std::array<double, 4>& expected) {
  const std::vector<double> found = hessian_at(f, x, y);
  INFO(name << " at " << x << ", " << y << ": " << found[0] << ' ' << found[1] << ' ' << found[2] << ' '
            << found[3]);
  CHECK(agrees({found[0], found[1], found[2], found[3]}, expected));
}
}  // namespace

TEST_CASE("exponentials have their first three derivatives at zero", "[autodiff][higher]") {
  check("exp", [](auto x) { return exp(x); }, 0, {1, 1, 1, 1});
  check("exp2", [](auto x) { return exp2(x); }, 0, {1, ln2, ln2 * ln2, ln2 * ln2 * ln2});
  check("expm1", [](auto x) { return expm1(x); }, 0, {0, 1, 1, 1});
  check("log1p", [](auto x) { return log1p(x); }, 0, {0, 1, -1, 2});
  check("log", [](auto x) { return log(x); }, 1, {0, 1, -1, 2});
  check("log2", [](auto x) { return log2(x); }, 1, {0, 1 / ln2, -1 / ln2, 2 / ln2});
  const double ln10 = std::numbers::ln10;
  check("log10", [](auto x) { return log10(x); }, 1, {0, 1 / ln10, -1 / ln10, 2 / ln10});
  check("sigmoid", [](auto x) { return sigmoid(x); }, 0, {0.5, 0.25, 0, -0.125});
  check("sigmoid", [](auto x) { return sigmoid(-x); }, 0, {0.5, -0.25, 0, 0.125});
  check("sigmoid", [](auto x) { return sigmoid(x); }, ln2, {2. / 3, 2. / 9, -2. / 27, -2. / 27});
  check("sigmoid", [](auto x) { return sigmoid(x); }, -ln2, {1. / 3, 2. / 9, 2. / 27, -2. / 27});
  check("softplus", [](auto x) { return softplus(x); }, 0, {ln2, 0.5, 0.25, 0});
  check("softplus", [](auto x) { return softplus(x); }, 1e3, {1e3, 1, 0, 0});
  check("softplus", [](auto x) { return softplus(x); }, -1e3, {0, 0, 0, 0});
}

TEST_CASE("trigonometric and hyperbolic functions have their first three derivatives at zero",
          "[autodiff][higher]") {
  check("sin", [](auto x) { return sin(x); }, 0, {0, 1, 0, -1});
  check("cos", [](auto x) { return cos(x); }, 0, {1, 0, -1, 0});
  check("tan", [](auto x) { return tan(x); }, 0, {0, 1, 0, 2});
  check("asin", [](auto x) { return asin(x); }, 0, {0, 1, 0, 1});
  check("acos", [](auto x) { return acos(x); }, 0, {std::numbers::pi / 2, -1, 0, -1});
  check("atan", [](auto x) { return atan(x); }, 0, {0, 1, 0, -2});
  check("sinh", [](auto x) { return sinh(x); }, 0, {0, 1, 0, 1});
  check("cosh", [](auto x) { return cosh(x); }, 0, {1, 0, 1, 0});
  check("tanh", [](auto x) { return tanh(x); }, 0, {0, 1, 0, -2});
  const double half = std::atanh(0.5);  // where the slope of tanh changes its formula
  for (const double x : {half, half - 1e-9, half + 1e-9}) {
    const double t = std::tanh(x), s = 1 - t * t;
    check("tanh", [](auto v) { return tanh(v); }, x, {t, s, -2 * t * s, s * (4 * t * t - 2 * s)});
  }
  check("asinh", [](auto x) { return asinh(x); }, 0, {0, 1, 0, -1});
  check("acosh", [](auto x) { return acosh(x); }, 2,
        {std::acosh(2.0), 1 / root3, -2 / (3 * root3), 1 / root3});
  check("atanh", [](auto x) { return atanh(x); }, 0, {0, 1, 0, 2});
  check("asin", [](auto x) { return asin(x); }, 1e-166, {1e-166, 1, 1e-166, 1});
  check("atanh", [](auto x) { return atanh(x); }, 1e-166, {1e-166, 1, 2e-166, 2});
}

TEST_CASE("powers and lengths have their first three derivatives at zero and at one", "[autodiff][higher]") {
  check("square", [](auto x) { return square(x); }, 0, {0, 0, 2, 0});
  check("sqrt", [](auto x) { return sqrt(x); }, 1, {1, 0.5, -0.25, 0.375});
  check("cbrt", [](auto x) { return cbrt(x); }, -1, {-1, 1. / 3, 2. / 9, 10. / 27});
  check("cbrt", [](auto x) { return cbrt(x); }, 0x1p999, {0x1p333, 0x1p-666 / 3, 0, 0});
  for (const double power : {0., 1., 2., 3., 4.}) {
    const double second = power * (power - 1), third = second * (power - 2);
    const auto f = [=](auto x) { return pow(x, power); };
    check("pow", f, 1, {1, power, second, third});
    check("pow", f, 0,
          {power == 0. ? 1. : 0., power == 1 ? 1. : 0., power == 2 ? 2. : 0., power == 3 ? 6. : 0.});
  }
  check("pow", [](auto y) { return pow(2, y); }, 0, {1, ln2, ln2 * ln2, ln2 * ln2 * ln2});
  check("hypot", [](auto x) { return hypot(x, 2); }, 0, {2, 0, 0.5, 0});
  check("hypot", [](auto x) { return hypot(2, x); }, 1e-180, {2, 0.5e-180, 0.5, -0.375e-180});
  check("hypot", [](auto x) { return hypot(x, 3, 4); }, 0, {5, 0, 0.2, 0});
  check("atan2", [](auto y) { return atan2(y, 2); }, 0, {0, 0.5, 0, -0.25});
  check("atan2", [](auto x) { return atan2(1, x); }, 0, {std::numbers::pi / 2, -1, 0, 2});
}

TEST_CASE("error and gamma functions have their first three derivatives at zero and at one",
          "[autodiff][higher]") {
  const double slope = 2 * std::numbers::inv_sqrtpi;
  check("erf", [](auto x) { return erf(x); }, 0, {0, slope, 0, -2 * slope});
  check("erfc", [](auto x) { return erfc(x); }, 0, {1, -slope, 0, 2 * slope});
  const double euler = std::numbers::egamma, zeta2 = std::numbers::pi * std::numbers::pi / 6,
               zeta3 = 1.2020569031595942;
  check("lgamma", [](auto x) { return lgamma(x); }, 1, {0, -euler, zeta2, -2 * zeta3});
  check("tgamma", [](auto x) { return tgamma(x); }, 1,
        {1, -euler, euler * euler + zeta2, -euler * euler * euler - 3 * euler * zeta2 - 2 * zeta3});
  const double zeta4 = zeta2 * zeta2 * 2 / 5;
  check("digamma", [](auto x) { return digamma(x); }, 1, {-euler, zeta2, -2 * zeta3, 6 * zeta4});
}

TEST_CASE("higher derivatives at kinks and ties are those of the side that is taken", "[autodiff][higher]") {
  check("abs", [](auto x) { return abs(x); }, 0, {0, 0, unknown, unknown});
  check("abs", [](auto x) { return abs(x * x * x); }, -1, {1, -3, 6, -6});
  check("max", [](auto x) { return max(x * x * x, x); }, 1, {1, 2, 3, 3});  // half of each side
  check("min", [](auto x) { return min(x, x * x * x); }, 1, {1, 2, 3, 3});
  check("clamp", [](auto x) { return clamp(x * x * x, -1, 1); }, 1, {1, 3, 6, 6});
  check("fdim", [](auto x) { return fdim(x * x * x, x); }, 1, {0, 2, 6, 6});
  check("fmod", [](auto x) { return fmod(x * x * x, 3); }, 2, {2, 12, 12, 6});
  check("remainder", [](auto x) { return remainder(x * x * x, 3); }, 2, {-1, 12, 12, 6});
  check("copysign", [](auto x) { return copysign(x * x * x, -1); }, 2, {-8, -12, -12, -6});
  check("fma", [](auto x) { return fma(x, x, x); }, 0, {0, 1, 2, 0});
}

TEST_CASE("functions of two variables have their Hessians at ties and zeros", "[autodiff][higher]") {
  const auto soft_maximum = [](auto x, auto y) { return logsumexp(x, y); };
  check_hessian("logsumexp", soft_maximum, 1, 1, {0.25, -0.25, -0.25, 0.25});
  check_hessian("logsumexp", soft_maximum, -1e8, -1e8, {0.25, -0.25, -0.25, 0.25});
  check_hessian("logsumexp", soft_maximum, ln2, 0, {2. / 9, -2. / 9, -2. / 9, 2. / 9});
  check_hessian("logsumexp", soft_maximum, 1e308, -1e308, {0, 0, 0, 0});
  check_hessian("x y", [](auto x, auto y) { return x * y; }, 0, 0, {0, 1, 1, 0});
  check_hessian("x / y", [](auto x, auto y) { return x / y; }, 0, 2, {0, -0.25, -0.25, 0});
  const auto length = [](auto x, auto y) { return hypot(x, y); };
  check_hessian("hypot", length, 3, 4, {0.128, -0.096, -0.096, 0.072});
  check_hessian("hypot", length, 2, 1e-180, {0, -0.25e-180, -0.25e-180, 0.5});
  check_hessian("hypot", length, 0, 0, {unknown, unknown, unknown, unknown});
  const auto angle = [](auto y, auto x) { return atan2(y, x); };
  check_hessian("atan2", angle, 1, 1, {-0.5, 0, 0, 0.5});
  check_hessian("atan2", angle, 0, -2, {0, -0.25, -0.25, 0});
  check_hessian("atan2", angle, 0, 0, {unknown, unknown, unknown, unknown});
  const auto power = [](auto x, auto y) { return pow(x, y); };
  check_hessian("pow", power, 1, 1, {0, 1, 1, 0});
  check_hessian("pow", power, 1, 3, {6, 1, 1, 0});
  check_hessian("pow", power, 2, 2, {2, 2 + 4 * ln2, 2 + 4 * ln2, 4 * ln2 * ln2});
}

TEST_CASE("the reductions of a range have their Hessians at ties and zeros", "[autodiff][higher]") {
  const auto hessian = [](const auto& f, std::vector<double> x) {
    const std::vector<double> h =
        tapestry::hessian([&](auto v) { return f(std::vector(v.begin(), v.end())); }, x);
    return Series{h[0], h[1], h[2], h[3]};
  };
  CHECK(agrees(hessian([](const auto& v) { return logsumexp(v); }, {1, 1}), {0.25, -0.25, -0.25, 0.25}));
  const auto share = [](const auto& v) { return softmax(v)[0]; };
  CHECK(agrees(hessian(share, {ln2, 0}), {-2. / 27, 2. / 27, 2. / 27, -2. / 27}));
  CHECK(agrees(hessian(share, {1, 1}), {0, 0, 0, 0}));
  const auto length = [](const auto& v) { return norm(v); };
  CHECK(agrees(hessian(length, {3, 4}), {0.128, -0.096, -0.096, 0.072}));
  CHECK(agrees(hessian(length, {0, -2}), {0.5, 0, 0, 0}));
  CHECK(agrees(hessian(length, {0, 0}), {unknown, unknown, unknown, unknown}));
  CHECK(agrees(hessian([](const auto& v) { return dot(v, v); }, {0, 1}), {2, 0, 0, 2}));
}

namespace {
/// Gradient and Hessian of f at (x, y) against f_x, f_y, f_xx, f_xy, f_xy, f_yy of a closed form.
template <class Function>
void check_within(double bound, const Function& f, double x, double y, const std::array<Wide, 6>& expected) {
  const auto function = [&](auto v) { return f(v[0], v[1]); };
  const std::vector<double> slopes = tapestry::gradient(function, std::array{x, y}).gradient,
                            curvatures = hessian_at(f, x, y);
  for (std::size_t i = 0; i < 6; ++i) {
    const double found = i < 2 ? slopes[i] : curvatures[i - 2];
    INFO("number " << i << " at " << x << ", " << y << ": " << found << " for " << expected[i]);
    CHECK(ulps(found, expected[i]) <= bound);
  }
}
}  // namespace

TEST_CASE("lengths have two derivatives within 6 ulp, whether their legs are denormal or huge",
          "[autodiff][higher]") {
  const auto length = [](auto x, auto y) { return hypot(x, y); };
  const auto with_zero = [](auto x, auto y) { return hypot(x, y, 0.0); };
  const std::vector<double> legs = {0,    3e-322, 1e-320, -2e-310, 7e-308, 1e-200, 1e-30,
                                    -0.5, 3,      1e30,   1e200,   -4e307, 1e308,  1.7e308};
  for (const double x : legs)
    for (const double y : legs) {
      if (x == 0 && y == 0) continue;  // the subgradient
      const auto a = static_cast<Wide>(x), b = static_cast<Wide>(y), h = std::hypot(a, b), cubed = h * h * h;
      const std::array<Wide, 6> expected = {a / h,          b / h,          b * b / cubed,
                                            -a * b / cubed, -a * b / cubed, a * a / cubed};
      check_within(6, length, x, y, expected);  // five rounded operations, two of them hypot's
      check_within(6, with_zero, x, y, expected);
    }
}

TEST_CASE("powers have two derivatives within 10 ulp, whether they are denormal or overflow",
          "[autodiff][higher]") {
  const auto power = [](auto x, auto y) { return pow(x, y); };
  const std::vector<std::array<double, 2>> points = {
      {1e-300, 1.07}, {1e-300, 1.0785}, {2, -1074},    {2, -1075},    {2, -1073.5}, {1e-300, 1},
      {1e-200, 1.55}, {1e-320, 1},      {1e-320, 1.5}, {1e300, 1.03}, {1e300, 1.8}, {1e300, -1.07},
      {1e300, -0.9},  {3, 647.5},       {1.5, 1755},   {0.3, 615},    {0.3, 620.5}, {1e-5, 64.3},
      {1e5, -64.7},   {1e-160, 3},      {5e-324, 2},   {1.7e308, 2},  {2.5, 1.5},   {0.5, -2.25}};
  for (const auto& [x, y] : points) {
    const auto a = static_cast<Wide>(x), b = static_cast<Wide>(y), ln = std::log(a),
               lower = std::pow(a, b - 1), itself = std::pow(a, b);
    const Wide mixed = lower * (1 + b * ln);
    // Two values of pow, or one and its square root twice, a logarithm and at most six other operations.
    check_within(10, power, x, y,
                 {b * lower, itself * ln, b * (b - 1) * std::pow(a, b - 2), mixed, mixed, itself * ln * ln});
  }
  const std::vector<double> negative = hessian_at(power, -2, -1072);
  CHECK(ulps(negative[0], Wide(1072 * 1073) * std::ldexp(Wide(1), -1074)) <= 1);
}

TEST_CASE("derivatives have their limits at infinity", "[autodiff][higher]") {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const double half_pi = std::numbers::pi / 2;
  for (const double far : {1e308, infinity}) {
    check("erf", [](auto x) { return erf(x); }, far, {1, 0, 0, 0});
    check("erf", [](auto x) { return erf(x); }, -far, {-1, 0, 0, 0});
    check("erfc", [](auto x) { return erfc(x); }, far, {0, 0, 0, 0});
    check("erfc", [](auto x) { return erfc(x); }, -far, {2, 0, 0, 0});
    check("tanh", [](auto x) { return tanh(x); }, far, {1, 0, 0, 0});
    check("atan", [](auto x) { return atan(x); }, -far, {-half_pi, 0, 0, 0});
    check("sigmoid", [](auto x) { return sigmoid(x); }, far, {1, 0, 0, 0});
    check("softplus", [](auto x) { return softplus(x); }, -far, {0, 0, 0, 0});
    check("exp", [](auto x) { return exp(x); }, -far, {0, 0, 0, 0});
    check("exp2", [](auto x) { return exp2(x); }, -far, {0, 0, 0, 0});
    check("expm1", [](auto x) { return expm1(x); }, -far, {-1, 0, 0, 0});
    check("hypot", [](auto x) { return hypot(x, 1.0); }, far, {far, 1, 0, 0});
    check("atan2", [](auto x) { return atan2(x, 1.0); }, far, {half_pi, 0, 0, 0});
  }
  check("log", [](auto x) { return log(x); }, infinity, {infinity, 0, 0, 0});
  check("sqrt", [](auto x) { return sqrt(x); }, infinity, {infinity, 0, 0, 0});
  check("pow", [](auto x) { return pow(x, -2.0); }, infinity, {0, 0, 0, 0});
  CHECK(hessian_at([](auto x, auto y) { return pow(x, y); }, infinity, -2) == std::vector<double>(4));
  CHECK(hessian_at([](auto x, auto y) { return pow(x, y); }, 2, -infinity) == std::vector<double>(4));
}

TEST_CASE("derivatives of duals that overflow are infinite with their sign up to the third, not NaN",
          "[autodiff][higher]") {
  constexpr double infinity = std::numeric_limits<double>::infinity();
  const auto check = [](const char* name, double x, const Series& expected, const auto& f) {
    const Series found = in_forward_mode(f, x);
    INFO(name << " at " << x << ": " << found[0] << ' ' << found[1] << ' ' << found[2] << ' ' << found[3]);
    CHECK(agrees(found, expected));
  };
  const Series all{infinity, infinity, infinity, infinity};
  for (const double x : {1026.0, 1e308, infinity}) {
    check("exp", x, all, [](auto v) { return exp(v); });
    check("exp2", x, all, [](auto v) { return exp2(v); });
    check("exp10", x, all, [](auto v) { return exp10(v); });
    check("expm1", x, all, [](auto v) { return expm1(v); });
    check("tgamma", x, all, [](auto v) { return tgamma(v); });
  }
  check("exp10", 308.2, {std::pow(10.0, 308.2), infinity, infinity, infinity},
        [](auto v) { return exp10(v); });
  check("tgamma", 171.63, all, [](auto v) { return tgamma(v); });
  // (1/x)' = −1/x², (1/x)″ = 2/x³, (1/x)‴ = −6/x⁴.
  for (const double x : {1e-155, 1e-250, 1e-307}) {
    check("1 / x", x, {1 / x, -infinity, infinity, -infinity}, [](auto v) { return 1 / v; });
    check("1 / x", -x, {-1 / x, -infinity, -infinity, -infinity}, [](auto v) { return 1 / v; });
    check("x^-1", x, {1 / x, -infinity, infinity, -infinity}, [](auto v) { return pow(v, -1); });
  }
  check("1 / x", 0.0, {infinity, -infinity, infinity, -infinity}, [](auto v) { return 1 / v; });
  check("1 / x", -0.0, {-infinity, -infinity, -infinity, -infinity}, [](auto v) { return 1 / v; });
  // 0^y · logⁿ 0 for y < 0.
  check("0^y", -1, {infinity, -infinity, infinity, -infinity}, [](auto v) { return pow(0, v); });
}

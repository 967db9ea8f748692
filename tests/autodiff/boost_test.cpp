#include <tapestry/autodiff/boost.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"

#if __has_include(<boost/numeric/odeint.hpp>)
#include <boost/math/special_functions/bessel.hpp>
#include <boost/math/special_functions/erf.hpp>
#include <boost/math/special_functions/expint.hpp>
#include <boost/math/special_functions/hermite.hpp>
#include <boost/math/special_functions/legendre.hpp>
#include <boost/numeric/odeint.hpp>
#include <cmath>
#include <limits>
#include <vector>

#include <tapestry/autodiff.hpp>

namespace odeint = boost::numeric::odeint;
using tapestry::Variable, tapestry::test::ActiveTape;

namespace {
/// Value and slope of f at x, which also comes as a formula.
struct Expected {
  double value, slope;
};

template <class Function>
void check(const char* name, Function f, double at, const Expected& expected) {
  INFO(name);
  ActiveTape<double> tape;
  const auto x = tape.input(at);
  const Variable<double> y = f(x), of_formula = f(-(-x) * 1.0);
  tape.reverse(y + of_formula);
  CHECK(y.value() == Approx(expected.value).epsilon(1e-13));
  CHECK(of_formula.value() == y.value());
  CHECK(x.adjoint() == Approx(2 * expected.slope).epsilon(1e-12));
}
}  // namespace

TEST_CASE("functions of Boost.Math take variables and formulas of them", "[autodiff][boost]") {
  check("J0", [](const auto& x) { return boost::math::cyl_bessel_j(0, x); }, 1.3,
        {boost::math::cyl_bessel_j(0, 1.3), -boost::math::cyl_bessel_j(1, 1.3)});
  check("J1", [](const auto& x) { return boost::math::cyl_bessel_j(1, x); }, 40.0,
        {boost::math::cyl_bessel_j(1, 40.0),
         (boost::math::cyl_bessel_j(0, 40.0) - boost::math::cyl_bessel_j(2, 40.0)) / 2});
  check("P3", [](const auto& x) { return boost::math::legendre_p(3, x); }, 0.3,
        {(5 * 0.027 - 3 * 0.3) / 2, (15 * 0.09 - 3) / 2});
  check("H3", [](const auto& x) { return boost::math::hermite(3, x); }, 0.3,
        {8 * 0.027 - 12 * 0.3, 24 * 0.09 - 12});
  check("erf", [](const auto& x) { return boost::math::erf(x); }, 0.3,
        {std::erf(0.3), 2 / std::sqrt(std::acos(-1.0)) * std::exp(-0.09)});
  check("Ei", [](const auto& x) { return boost::math::expint(x); }, 0.3,
        {-0.30266853926582588, std::exp(0.3) / 0.3});
}

TEST_CASE("a controlled stepper of Boost.Odeint integrates variables", "[autodiff][boost]") {
  using State = std::vector<Variable<double>>;
  ActiveTape<double> tape;
  const auto rate = tape.input(0.7);
  State x{Variable<double>(2.0)};
  const auto decay = [&](const State& at, State& slope, const Variable<double>&) {
    slope[0] = -rate * at[0];
  };
  odeint::integrate_adaptive(
      odeint::make_controlled(1e-11, 1e-11, odeint::runge_kutta_dopri5<State, Variable<double>>()), decay, x,
      Variable<double>(0.0), Variable<double>(1.5), Variable<double>(0.1));
  tape.reverse(x[0]);
  CHECK(x[0].value() == Approx(2 * std::exp(-0.7 * 1.5)).epsilon(1e-9));
  CHECK(rate.adjoint() == Approx(-1.5 * 2 * std::exp(-0.7 * 1.5)).epsilon(1e-8));
}
#else
TEST_CASE("Boost takes variables", "[autodiff][boost]") { WARN("no Boost: skipped"); }
#endif

TEST_CASE("a variable's whole part is refused where no integer holds it", "[autodiff][boost]") {
  const auto whole = [](double value) { return tapestry::itrunc(tapestry::Variable<double>(value), 0); };
  CHECK(whole(2.9) == 2);
  CHECK(whole(-2.9) == -2);
  CHECK(whole(-2147483648.5) == std::numeric_limits<int>::min());
  for (const double value : {2147483648.0, -2147483649.0, std::numeric_limits<double>::quiet_NaN(),
                             std::numeric_limits<double>::infinity()})
    CHECK_THROWS_AS(whole(value), tapestry::NumericError);
  CHECK(tapestry::iround(tapestry::Variable<double>(2.5), 0) == 3);
  CHECK(tapestry::lltrunc(tapestry::Variable<double>(-4e18), 0) == -4000000000000000000LL);
}

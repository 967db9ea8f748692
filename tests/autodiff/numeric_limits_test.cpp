#include <tapestry/autodiff.hpp>

#include "../support/catch.hpp"

using tapestry::Dual, tapestry::Variable;

TEST_CASE("limits of variables and duals are those of the numbers beneath", "[autodiff][limits]") {
  using V = std::numeric_limits<Variable<double>>;
  using N = std::numeric_limits<double>;
  STATIC_REQUIRE(V::is_specialized);
  STATIC_REQUIRE(V::digits == N::digits);
  STATIC_REQUIRE(V::max_exponent == N::max_exponent);
  STATIC_REQUIRE(std::same_as<decltype(V::max()), Variable<double>>);
  CHECK(V::epsilon().value() == N::epsilon());
  CHECK(V::min().value() == N::min());
  CHECK(V::max().value() == N::max());
  CHECK(V::lowest().value() == N::lowest());
  CHECK(V::infinity().value() == N::infinity());
  CHECK(V::denorm_min().value() == N::denorm_min());
  CHECK(V::round_error().value() == N::round_error());
  CHECK(isnan(V::quiet_NaN()));
  CHECK_FALSE(V::epsilon().is_active());
  STATIC_REQUIRE(std::numeric_limits<const Variable<float>>::digits == 24);
  using D = Dual<Dual<float, 3>>;
  CHECK(std::numeric_limits<D>::epsilon() == std::numeric_limits<float>::epsilon());
  CHECK(std::numeric_limits<D>::max().tangent() == 0);
  CHECK(std::numeric_limits<Variable<D>>::min() == std::numeric_limits<float>::min());
}

TEST_CASE("limits of a formula are those of the variable that it becomes", "[autodiff][limits]") {
  const auto formula = Variable<double>(2) * Variable<double>(3) + 1;
  using F = std::numeric_limits<std::remove_cv_t<decltype(formula)>>;
  STATIC_REQUIRE(F::digits10 == 15);
  STATIC_REQUIRE(std::same_as<decltype(F::min()), Variable<double>>);
  CHECK(formula * F::epsilon() == 7 * std::numeric_limits<double>::epsilon());
}

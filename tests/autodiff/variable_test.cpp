#include <tapestry/autodiff/functions.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"

using tapestry::Variable, tapestry::test::ActiveTape;

TEMPLATE_TEST_CASE("operators have the derivatives worked out by hand", "[autodiff][variable]", float,
                   double) {
  using T = TestType;
  ActiveTape<T> tape;
  const Variable<T> x = tape.input(3), y = tape.input(4);
  const auto check = [&](const Variable<T>& f, T value, T by_x, T by_y) {
    tape.reverse(f);
    CHECK(f.value() == value);
    CHECK(x.adjoint() == by_x);
    CHECK(y.adjoint() == by_y);
  };
  check(x + y, 7, 1, 1);
  check(x - y, -1, 1, -1);
  check(x * y, 12, 4, 3);
  check(x / y, T(0.75), T(0.25), T(-0.1875));
  check(-x, -3, -1, 0);
  check(+x, 3, 1, 0);
  check(x + 2, 5, 1, 0);
  check(2 - y, -2, 0, -1);
  check(2.0 * x, 6, 2, 0);
  check(x / 2, T(1.5), T(0.5), 0);
  check(6 / y, T(1.5), 0, T(-0.375));
  check((x - y) * (x + y) / T(2), T(-3.5), 3, -4);
}

TEST_CASE("comparisons look at values", "[autodiff][variable]") {
  ActiveTape<double> tape;
  const Variable<double> x = tape.input(2.0);
  const Variable<double> y = 3.0;
  CHECK(x < y);
  CHECK(x * 2 >= y + 1);
  CHECK(2 == x);
  CHECK(x != y);
  CHECK(x > 1);
  CHECK_FALSE(x / 0 - x / 0 == x / 0 - x / 0);  // NaN
  CHECK(tape.statement_count() == 1);
}

TEST_CASE("a formula kept by auto holds its operands by value", "[autodiff][variable]") {
  ActiveTape<double> tape;
  const Variable<double> x = tape.input(2.0);
  auto formula = [](const Variable<double>& a) {
    const Variable<double> local = a * 3;
    return local * local + 1.0;
  }(x);
  const Variable<double> y = formula;
  tape.reverse(y);
  CHECK(y.value() == 37);
  CHECK(x.adjoint() == 36);
}

TEST_CASE("passive() stops the gradient", "[autodiff][variable]") {
  ActiveTape<double> tape;
  const Variable<double> x = tape.input(2.0);
  tape.reverse(Variable<double>(passive(x * x) * x));
  CHECK(x.adjoint() == 4);
}

TEST_CASE("passive variables in a formula take no more tape than numbers, copies and passive results none",
          "[autodiff][variable]") {
  const auto bytes_of = [](const auto& two, const auto& six, double* slopes) {
    ActiveTape<double> tape;
    const Variable<double> x = tape.input(3.0), y = tape.input(5.0);
    const std::size_t before = tape.statement_bytes();
    const Variable<double> z = y + two * (x + two * y - x) / six - two;
    const Variable<double> copy = z, passive_result = Variable<double>(two) * six;
    const std::size_t bytes = tape.statement_bytes() - before;
    CHECK(tape.statement_count() == 3);
    CHECK(tape.operand_count() == 4);  // x and y twice
    CHECK_FALSE(passive_result.is_active());
    tape.reverse(copy);
    slopes[0] = x.adjoint();
    slopes[1] = y.adjoint();
    return bytes;
  };
  double by_numbers[2], by_variables[2];
  CHECK(bytes_of(Variable<double>(2.0), Variable<double>(8.0), by_variables) ==
        bytes_of(2.0, 8.0, by_numbers));
  CHECK(std::ranges::equal(by_variables, by_numbers));
  CHECK(by_variables[0] == 0);
  CHECK(by_variables[1] == 1.5);  // 1 + 2 · 2 / 8
}

TEST_CASE("the slope by a passive variable does not matter, and a zero passes no infinity on",
          "[autodiff][variable]") {
  ActiveTape<double> tape;
  const Variable<double> x = tape.input(-2.0), zero = 0.0, cube = 3.0;
  const Variable<double> power = pow(x, cube);  // by the exponent NaN: log(−2)
  tape.reverse(power);
  CHECK(x.adjoint() == 12);
  const Variable<double> pole = x / zero;
  tape.reverse(pole);
  CHECK(x.adjoint() == std::numeric_limits<double>::infinity());
  tape.reverse(Variable<double>(x * zero / zero));
  CHECK(x.adjoint() == 0);  // 0 · ∞
  CHECK(std::isnan(Variable<double>(x * zero / zero).value()));
  const Variable<double> unknown = std::numeric_limits<double>::quiet_NaN();
  tape.reverse(Variable<double>(x * unknown * cube));
  CHECK(std::isnan(x.adjoint()));
}

TEST_CASE("record_partials is one statement without the passive operands", "[autodiff][variable]") {
  ActiveTape<double> tape;
  const std::array<Variable<double>, 3> x = {tape.input(1.0), Variable<double>(2.0), tape.input(3.0)};
  const std::array<double, 3> partials = {10, 20, 30};
  const auto y = tapestry::record_partials<double>(5, x, partials);
  CHECK(tape.statement_count() == 3);
  CHECK(tape.operand_count() == 2);
  tape.reverse(y);
  CHECK(x[0].adjoint() == 10);
  CHECK(x[2].adjoint() == 30);
  const std::vector<double> too_few = {1};
  CHECK_THROWS_AS(tapestry::record_partials<double>(5, x, too_few), tapestry::DomainError);
  const std::array<Variable<double>, 1> frozen = {Variable<double>(2.0)};
  CHECK_FALSE(tapestry::record_partials<double>(5, frozen, too_few).is_active());
}

TEST_CASE("a variable is as small as its value and its place", "[autodiff][variable]") {
  STATIC_REQUIRE(sizeof(Variable<double>) == 16);
  STATIC_REQUIRE(std::is_trivially_copyable_v<Variable<double>>);
  STATIC_REQUIRE_FALSE(std::is_constructible_v<Variable<float>, Variable<double>>);
}

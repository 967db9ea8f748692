#include <tapestry/autodiff/arrays/gather.hpp>
#include <tapestry/autodiff/detail/arrays/extreme.hpp>

#include "../../support/active_tape.hpp"
#include "../../support/catch.hpp"
#include "../../support/finite_difference.hpp"
#include "../../support/random_array.hpp"

using tapestry::Array, tapestry::ArrayVariable, tapestry::Variable, tapestry::test::ActiveTape,
    tapestry::test::random_array;

TEMPLATE_TEST_CASE("extremes and means along an axis agree with central differences", "[autodiff][extreme]",
                   float, double) {
  using T = TestType;
  Array<T, 3> x({3, 4, 5});
  for (std::size_t i = 0; i < 60; ++i) x.data()[i] = static_cast<T>(i * 37 % 60) / 30 - 1;  // far from ties
  const auto direction = tapestry::test::random_direction<T>({3, 4, 5}, 2);
  const auto check = [&](const auto& f) {
    const auto value = [&](const Array<T, 3>& at) { return Variable<T>(f(ArrayVariable<T, 3>(at))).value(); };
    ActiveTape<T> tape;
    const auto input = tape.input(x);
    tape.reverse(Variable<T>(f(input)));
    const T numeric = tapestry::test::central_difference(value, x, direction);
    CHECK(std::abs(tapestry::test::dot(input.adjoint(), direction) - numeric) <=
          tapestry::test::central_difference_tolerance(value(x)));
  };
  for (const std::size_t axis : {0U, 1U, 2U}) {
    check([=](const auto& a) { return norm(largest_along(a, axis)); });
    check([=](const auto& a) { return norm(smallest_along(a, axis)); });
    check([=](const auto& a) { return norm(mean_along(a, axis)); });
  }
}

TEST_CASE("extremes of ties, NaN and infinities along an axis", "[autodiff][extreme]") {
  const double nan = std::numeric_limits<double>::quiet_NaN(),
               infinity = std::numeric_limits<double>::infinity();
  ActiveTape<double> tape;
  const auto x = tape.input(Array<double, 2>{{2, 2, 1}, {1, nan, 3}, {-infinity, 0, infinity}});
  const ArrayVariable<double, 1> top = largest_along(x, 1), bottom = smallest_along(x, 1);
  CHECK(top.value()(0) == 2);
  CHECK(std::isnan(top.value()(1)));
  CHECK(std::isnan(bottom.value()(1)));
  CHECK(top.value()(2) == infinity);
  CHECK(bottom.value()(2) == -infinity);
  tape.reverse(top, Array<double, 1>{1, 2, 3});
  CHECK(x.adjoint() == Array<double, 2>{{1, 0, 0}, {0, 2, 0}, {0, 0, 3}});
  tape.reverse(bottom, Array<double, 1>{1, 2, 3});
  CHECK(x.adjoint() == Array<double, 2>{{0, 0, 1}, {0, 2, 0}, {3, 0, 0}});
}

TEST_CASE("extremes name what does not fit", "[autodiff][extreme]") {
  const ArrayVariable<double, 2> x = random_array<double>({2, 3}, 1), none = Array<double, 2>({2, 0});
  CHECK_THROWS_WITH(largest_along(x, 2), "largest_along: axis 2 of [2, 3]");
  CHECK_THROWS_WITH(smallest_along(none, 1), "smallest_along: no elements along axis 1 of [2, 0]");
  CHECK(largest_along(none, 0).size() == 0);
  CHECK(std::isnan(mean_along(none, 1).value()(0)));
}

TEST_CASE("elements and extremes of an array of duals have second derivatives", "[autodiff][extreme]") {
  using D = tapestry::Dual<double>;
  ActiveTape<D> tape;
  const auto x = tape.input(Array<D, 1>{D(2, {1}), D(3, {0}), D(0.5, {0})});  // along the first
  const Variable<D> first = tapestry::element(x, {0}), top = tapestry::largest(x),
                    low = tapestry::smallest(tapestry::gather(x, {0, 2}));
  const Variable<D> root = first * first * top + low * first;  // x² y + z x
  tape.reverse(root);
  CHECK(x.adjoint()(0).value() == 2 * 2 * 3 + 0.5);
  CHECK(x.adjoint()(0).tangent() == 2 * 3);
  CHECK(x.adjoint()(1).tangent() == 2 * 2);
  CHECK(x.adjoint()(2).tangent() == 1);
}

#include <tapestry/autodiff/array_functions.hpp>

#include <cmath>
#include <limits>
#include <vector>

#include "../support/catch.hpp"
#include "../support/random_array.hpp"

using tapestry::Array;
using tapestry::ArrayVariable;
using tapestry::ShapeError;
using tapestry::Tape;
using tapestry::test::random_array;

TEST_CASE("matmul and affine equal the products worked out by hand", "[autodiff][array_functions]") {
  const Array<double, 2> a = {{1, 2}, {3, 4}};
  const Array<double, 2> b = {{5, 6}, {7, 8}};
  const ArrayVariable<double, 2> left = a;
  CHECK(matmul(left, b).value() == Array<double, 2>{{19, 22}, {43, 50}});
  CHECK(affine(left, b, Array<double, 1>{1, -1}).value() == Array<double, 2>{{18, 22}, {40, 52}});
}

TEST_CASE("plain arrays beside array variables cost one record and keep no adjoint",
          "[autodiff][array_functions]") {
  Tape<double> tape;
  const auto scope = tape.activate();
  Array<double, 1> plain = {1, 2};
  const auto x = tape.input(Array<double, 1>{3, 4});
  const ArrayVariable<double, 1> y = plain * x;
  CHECK(tape.record_count() == 2);
  CHECK(evaluated(x - plain).value() == Array<double, 1>{2, 2});
  CHECK(evaluated(Array<double, 1>{1, 1} + x).value() == Array<double, 1>{4, 5});
  tape.reverse(y, plain);
  CHECK(x.adjoint() == Array<double, 1>{1, 4});
  const ArrayVariable<double, 1> frozen = plain;
  const auto before = tape.statement_count();
  CHECK_FALSE(evaluated(frozen * frozen + plain).is_active());
  CHECK(tape.statement_count() == before);
}

TEST_CASE("a masked element cannot poison the gradient", "[autodiff][array_functions]") {
  Tape<double> tape;
  const auto scope = tape.activate();
  const auto x = tape.input(Array<double, 1>{0, 4});
  const auto root = sum(Array<double, 1>{0, 1} * sqrt(x));  // √0 has slope ∞
  tape.reverse(root);
  CHECK(x.adjoint() == Array<double, 1>{0, 0.25});
  const auto held = tape.input(Array<double, 1>{-1, 0, 0.5, 1, 2});
  tape.reverse(sum(clamp(held, 0, 1)));
  CHECK(held.adjoint() == Array<double, 1>{0, 1, 1, 1, 0});
}

TEST_CASE("special values of array reductions", "[autodiff][array_functions]") {
  const double infinity = std::numeric_limits<double>::infinity();
  const auto soft = [](const Array<double, 1>& x) { return logsumexp(ArrayVariable<double, 1>(x)).value(); };
  CHECK(soft(tapestry::zeros<double, 1>({0})) == -infinity);
  CHECK(soft({7}) == 7);
  CHECK(soft({1e308, -1e308}) == 1e308);
  CHECK(soft({-infinity, -infinity}) == -infinity);
  CHECK(std::isnan(soft({1, std::numeric_limits<double>::quiet_NaN()})));
  const auto total = [](const auto& x) { return sum(ArrayVariable<double, 1>(x)).value(); };
  CHECK(total(tapestry::zeros<double, 1>({0})) == 0);
  CHECK(total(Array<double, 1>{infinity, 1}) == infinity);
  const auto ones = tapestry::filled<float, 1>({20'000'000}, 1.0F);  // a float counter would stop at 2²⁴
  CHECK(sum(ArrayVariable<float, 1>(ones)).value() == 20'000'000.0F);
  Array<double, 1> tenths = tapestry::filled<double, 1>({1'000'000}, 0.1);
  CHECK(std::abs(total(tenths) / 1e5 - 1) <= 70 * std::numeric_limits<double>::epsilon());
}

TEST_CASE("array functions name what does not fit", "[autodiff][array_functions]") {
  const ArrayVariable<double, 2> x = random_array<double>({2, 3}, 1);
  const ArrayVariable<double, 2> y = random_array<double>({3, 2}, 2);
  CHECK_THROWS_WITH(x + y, "operator+: right operand is [3, 2], expected [2, 3]");
  CHECK_THROWS_WITH(y.value() * x, "operator*: right operand is [2, 3], expected [3, 2]");
  CHECK_THROWS_AS(dot(x, y), ShapeError);
  CHECK_THROWS_WITH(matmul(x, x), "matmul: right operand is [2, 3], expected [3, 3]");
  CHECK_THROWS_AS(affine(x, y, Array<double, 1>{1, 2}), ShapeError);
  CHECK_THROWS_WITH(element(x, {2, 0}), "element: index [2, 0] lies outside [2, 3]");
  CHECK_THROWS_AS(reshape<1>(x, {5}), ShapeError);
}

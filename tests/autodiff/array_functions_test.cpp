#include <tapestry/autodiff/array_functions.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"
#include "../support/random_array.hpp"

using tapestry::Array, tapestry::ArrayVariable, tapestry::ShapeError, tapestry::test::ActiveTape,
    tapestry::test::random_array;

namespace {
constexpr double epsilon = std::numeric_limits<double>::epsilon();
}

TEST_CASE("matmul and affine equal the products worked out by hand", "[autodiff][array_functions]") {
  const Array<double, 2> a = {{1, 2}, {3, 4}}, b = {{5, 6}, {7, 8}};
  const ArrayVariable<double, 2> left = a;
  CHECK(matmul(left, b).value() == Array<double, 2>{{19, 22}, {43, 50}});
  CHECK(affine(left, b, Array<double, 1>{1, -1}).value() == Array<double, 2>{{18, 22}, {40, 52}});
}

TEST_CASE("plain arrays beside array variables cost one record and keep no adjoint",
          "[autodiff][array_functions]") {
  ActiveTape<double> tape;
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
  ActiveTape<double> tape;
  const auto x = tape.input(Array<double, 1>{0, 4});
  const auto root = sum(Array<double, 1>{0, 1} * sqrt(x));  // √0 has slope ∞
  tape.reverse(root);
  CHECK(x.adjoint() == Array<double, 1>{0, 0.25});
  const auto held = tape.input(Array<double, 1>{-1, 0, 0.5, 1, 2});
  tape.reverse(sum(clamp(held, 0, 1)));
  CHECK(held.adjoint() == Array<double, 1>{0, 1, 1, 1, 0});
}

TEST_CASE("a reduction's result of no axes goes with numbers, scalars and arrays of any rank",
          "[autodiff][array_functions]") {
  ActiveTape<double> tape;
  const auto x = tape.input(Array<double, 1>{1, 2, 4});
  const auto s = tape.input(3.0);
  const ArrayVariable<double, 0> z = sum_along(x, 0);  // 7
  // f = (z + 1) + 2 / z − z² s: by x f′ = 1 − 2 / z² − 2 z s, by s −z².
  const ArrayVariable<double, 0> f = (z + 1.0) + 2 / z - z * z * s;
  CHECK(f.value()() == 8 + 2.0 / 7 - 147);
  tape.reverse(sum(f));
  const double slope = 1 - 2.0 / 49 - 42;  // of terms that round once or twice, of size 42
  for (const double found : x.adjoint()) CHECK(std::abs(found - slope) <= 42 * 4 * epsilon);
  CHECK(s.adjoint() == -49);

  // Beside arrays it repeats: g = Σ wᵢⱼ (z − yᵢⱼ) is linear in z and y.
  const Array<double, 2> w = {{1, 2, 3}, {4, 5, 6}};
  const auto y = tape.input(Array<double, 2>{{1, 1, 2}, {3, 5, 8}});
  const ArrayVariable<double, 2> difference = z - y;
  CHECK(difference.value() == Array<double, 2>{{6, 6, 5}, {4, 2, -1}});
  tape.reverse(sum(w * (z - y)));
  CHECK(x.adjoint() == Array<double, 1>{21, 21, 21});
  CHECK(y.adjoint() == Array<double, 2>(-w));
  tape.reverse(sum(exp(largest_along(x, 0) - x)));  // e³ + e² + 1; the sum goes to the largest one's slope
  CHECK(std::abs(x.adjoint()(2) - (std::exp(3) + std::exp(2))) <= 32 * epsilon);
  CHECK(std::abs(x.adjoint()(0) + std::exp(3)) <= 32 * epsilon);
  tape.reverse(sum(where(y < z, z * y, y)));  // 8 is not below 7
  CHECK(x.adjoint() == Array<double, 1>{12, 12, 12});
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
  const ArrayVariable<double, 2> x = random_array<double>({2, 3}, 1), y = random_array<double>({3, 2}, 2);
  CHECK_THROWS_WITH(x + y, "operator+: right operand is [3, 2], expected [2, 3]");
  CHECK_THROWS_WITH(y.value() * x, "operator*: right operand is [2, 3], expected [3, 2]");
  CHECK_THROWS_AS(dot(x, y), ShapeError);
  CHECK_THROWS_WITH(matmul(x, x), "matmul: right operand is [2, 3], expected [3, 3]");
  CHECK_THROWS_AS(affine(x, y, Array<double, 1>{1, 2}), ShapeError);
  CHECK_THROWS_WITH(element(x, {2, 0}), "element: index [2, 0] lies outside [2, 3]");
  CHECK_THROWS_AS(reshape<1>(x, {5}), ShapeError);
}

#include <tapestry/loss/detail/total_variation.hpp>

#include <cmath>
#include <limits>

#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"

namespace loss = tapestry::loss;
using tapestry::Array;
using tapestry::test::random_array;

TEST_CASE("total variation equals the steps worked out by hand", "[loss][total_variation]") {
  const Array<double, 3> picture = {{{0.0}, {1.0}}, {{-3.0}, {9.0}}};
  const auto mask = tapestry::filled<double, 2>({2, 2}, 1);
  CHECK(loss::total_variation(picture, mask, 0) == 4.0);  // |−3| down + |1| right
  CHECK(loss::total_variation(picture, mask, 4) == Approx((5 - 4) + (std::sqrt(17.0) - 4)).epsilon(1e-14));
}

TEST_CASE("total variation of a small step keeps its digits", "[loss][total_variation]") {
  const Array<double, 3> picture = {{{0.0}, {1e-9}}, {{0.0}, {0.0}}};
  const auto mask = tapestry::filled<double, 2>({2, 2}, 1);
  CHECK(loss::total_variation(picture, mask) == Approx(1e-18 / 2e-3).epsilon(1e-11));  // s² / 2ε
}

TEMPLATE_TEST_CASE("total_variation_adjoint agrees with central differences", "[loss][gradient]", float,
                   double) {
  const auto picture = random_array<TestType>({5, 7, 3}, 3);
  const auto mask = random_array<TestType>({5, 7}, 4);
  const auto direction = tapestry::test::random_direction<TestType>({5, 7, 3}, 5);
  const auto value = [&](const auto& image) { return loss::total_variation(image, mask, 0.1); };
  Array<TestType, 3> gradient = xt::zeros_like(picture);
  for (int half = 0; half < 2; ++half)  // two halves make a whole only if the adjoint adds
    loss::total_variation_adjoint(picture, mask, 0.1, TestType(0.5), gradient);
  // The third derivative of φ is at most 1/ε² = 100, and so is the truncation beside that of order one.
  const auto tolerance = 100 * tapestry::test::central_difference_tolerance(value(picture));
  CHECK(std::abs(tapestry::test::dot(gradient, direction) -
                 tapestry::test::central_difference(value, picture, direction)) <= tolerance);
}

TEST_CASE("a step of 0 has slope 0 even where the penalty has a kink", "[loss][total_variation]") {
  const auto flat = tapestry::filled<double, 3>({3, 3, 1}, 0.5);
  const auto mask = tapestry::filled<double, 2>({3, 3}, 1);
  auto gradient = tapestry::zeros<double, 3>({3, 3, 1});
  loss::total_variation_adjoint(flat, mask, 0, 1.0, gradient);
  CHECK((gradient == tapestry::zeros<double, 3>({3, 3, 1})));
  CHECK(loss::total_variation(flat, mask, 0) == 0);
}

TEST_CASE("total variation refuses masks of another size and an ε that is no length",
          "[loss][total_variation]") {
  const auto picture = random_array<double>({4, 4, 3}, 6);
  CHECK_THROWS_WITH(loss::total_variation(picture, random_array<double>({4, 5}, 7)),
                    "total_variation: mask is [4, 5], expected [4, 4]");
  const auto mask = random_array<double>({4, 4}, 7);
  CHECK_THROWS_AS(loss::total_variation(picture, mask, -1), tapestry::DomainError);
  CHECK_THROWS_AS(loss::total_variation(picture, mask, std::numeric_limits<double>::quiet_NaN()),
                  tapestry::DomainError);
}

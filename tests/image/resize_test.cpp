#include <tapestry/image/resize.hpp>

#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"

using namespace tapestry;
using namespace tapestry::test;

TEST_CASE("resize_bilinear equals weights worked out by hand", "[image][resize]") {
  const Array<double, 3> picture = {{{0.0}, {4.0}}, {{8.0}, {12.0}}};
  // Centres of the four outputs lie at −¼ (clamped to 0), ¼, ¾ and 1¼ (clamped to 1).
  const Array<double, 3> resized = image::resize_bilinear(picture, 1, 4);
  CHECK(resized(0, 0, 0) == 4.0);
  CHECK(resized(0, 1, 0) == 5.0);
  CHECK(resized(0, 2, 0) == 7.0);
  CHECK(resized(0, 3, 0) == 8.0);
}

TEST_CASE("resize_bilinear to the same size changes nothing", "[image][resize]") {
  const auto picture = random_array<float>({5, 7, 3}, 1);
  CHECK((image::resize_bilinear(picture, 5, 7) == picture));
}

TEMPLATE_TEST_CASE("resize_bilinear keeps a constant picture", "[image][resize]", float, double) {
  const auto picture = tapestry::filled<TestType, 3>({3, 9, 2}, TestType(0.3));
  const auto resized = image::resize_bilinear(picture, 17, 4);
  for (const TestType value : resized.storage()) {
    CHECK(std::abs(value - TestType(0.3)) <= 2 * std::numeric_limits<TestType>::epsilon());
  }
}

TEMPLATE_TEST_CASE("resize_bilinear_adjoint is the transpose", "[image][gradient]", float, double) {
  const auto [height, width] =
      GENERATE(std::pair<std::size_t, std::size_t>(9, 14), std::pair<std::size_t, std::size_t>(3, 2),
               std::pair<std::size_t, std::size_t>(1, 1));
  const auto x = random_array<TestType>({6, 5, 3}, 2, -1);
  const auto y = random_array<TestType>({height, width, 3}, 3, -1);
  Array<TestType, 3> x_adjoint = xt::zeros_like(x);
  image::resize_bilinear_adjoint(y, x_adjoint);
  image::resize_bilinear_adjoint(y, x_adjoint);  // adds
  const TestType forward = test::dot(y, image::resize_bilinear(x, height, width));
  // Each side sums no more than 378 products below 1, each off by a few ε.
  CHECK(std::abs(2 * forward - test::dot(x_adjoint, x)) <=
        8 * 378 * std::numeric_limits<TestType>::epsilon());
}

TEST_CASE("resize_bilinear refuses empty and absurd sizes", "[image][resize]") {
  const auto picture = random_array<double>({2, 2, 3}, 4);
  Array<double, 3> wrong = random_array<double>({2, 2, 1}, 5);
  CHECK_THROWS_AS(image::resize_bilinear(picture, 0, 3), DomainError);
  CHECK_THROWS_AS(image::resize_bilinear(picture, 3, std::size_t{1} << 40U), DomainError);
  CHECK_THROWS_AS(image::resize_bilinear(tapestry::zeros<double, 3>({0, 2, 3}), 2, 2), DomainError);
  CHECK_THROWS_AS(image::resize_bilinear_adjoint(picture, wrong), ShapeError);
}

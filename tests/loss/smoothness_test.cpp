#include <tapestry/loss/smoothness.hpp>

#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"

using namespace tapestry;
using namespace tapestry::test;

TEST_CASE("smoothness equals the steps worked out by hand", "[loss][smoothness]") {
  const Array<double, 3> render = {{{0.0}, {1.0}}, {{3.0}, {9.0}}};
  const Array<double, 2> mask = {{1.0, 1.0}, {1.0, 1.0}};
  CHECK(loss::smoothness(render, mask) == 10.0);  // 3² down + 1² right; the last row and column start no step
}

TEST_CASE("atlas_smoothness equals the steps worked out by hand", "[loss][smoothness]") {
  const Array<double, 2> texels = {{0.0}, {1.0}, {3.0}, {9.0}}, all = {{1.0, 1.0}, {1.0, 1.0}};
  CHECK(loss::atlas_smoothness(texels, all) == 9.0 + 1.0 + 64.0 + 36.0);
  const Array<double, 2> three = {{1.0, 1.0}, {1.0, 0.0}};  // the unused texel pulls on neither neighbour
  CHECK(loss::atlas_smoothness(texels, three) == 10.0);
}

TEMPLATE_TEST_CASE("smoothness ignores a constant colour shift", "[loss][smoothness]", float, double) {
  const auto render = random_array<TestType>({5, 7, 3}, 1);
  const auto mask = random_array<TestType>({5, 7}, 2);
  auto shifted = render;
  for (auto& value : shifted.storage()) value += TestType(1) / 4;
  const auto terms = TestType(2 * 4 * 6 * 3);  // each off by a few ε
  CHECK(std::abs(loss::smoothness(shifted, mask) - loss::smoothness(render, mask)) <=
        4 * terms * std::numeric_limits<TestType>::epsilon());
}

TEMPLATE_TEST_CASE("smoothness_adjoint agrees with central differences", "[loss][gradient]", float, double) {
  const auto render = random_array<TestType>({5, 7, 3}, 3);
  const auto mask = random_array<TestType>({5, 7}, 4);
  const auto direction = test::random_direction<TestType>({5, 7, 3}, 5);
  const auto value = [&](const auto& image) { return loss::smoothness(image, mask); };

  Array<TestType, 3> gradient = xt::zeros_like(render);
  for (int half = 0; half < 2; ++half)  // two halves make a whole only if the adjoint adds
    loss::smoothness_adjoint(render, mask, TestType(0.5), gradient);

  CHECK(std::abs(test::dot(gradient, direction) - test::central_difference(value, render, direction)) <=
        test::central_difference_tolerance(value(render)));
}

TEMPLATE_TEST_CASE("atlas_smoothness_adjoint agrees with central differences", "[loss][gradient]", float,
                   double) {
  const auto texels = random_array<TestType>({20, 3}, 6);
  const auto used = random_array<TestType>({4, 5}, 7);
  const auto direction = test::random_direction<TestType>({20, 3}, 8);
  const auto value = [&](const auto& colours) { return loss::atlas_smoothness(colours, used); };

  Array<TestType, 2> gradient = xt::zeros_like(texels);
  for (int half = 0; half < 2; ++half) loss::atlas_smoothness_adjoint(texels, used, TestType(0.5), gradient);

  CHECK(std::abs(test::dot(gradient, direction) - test::central_difference(value, texels, direction)) <=
        test::central_difference_tolerance(value(texels)));
}

TEST_CASE("smoothness under an all-zero mask is 0 and has no gradient", "[loss][smoothness]") {
  auto render = random_array<double>({4, 4, 3}, 9);
  render(1, 1, 0) = std::numeric_limits<double>::quiet_NaN();  // outside the mask: not read
  const auto mask = tapestry::zeros<double, 2>({4, 4});
  auto gradient = tapestry::zeros<double, 3>({4, 4, 3});
  CHECK(loss::smoothness(render, mask) == 0.0);
  loss::smoothness_adjoint(render, mask, 1.0, gradient);
  for (const double slope : gradient.storage()) CHECK(slope == 0.0);
}

TEST_CASE("smoothness passes a NaN inside the mask on", "[loss][smoothness]") {
  auto render = random_array<double>({4, 4, 3}, 10);
  render(1, 1, 0) = std::numeric_limits<double>::quiet_NaN();
  CHECK(std::isnan(loss::smoothness(render, tapestry::filled<double, 2>({4, 4}, 1.0))));
}

TEST_CASE("smoothness of a picture of one pixel is 0", "[loss][smoothness]") {
  CHECK(loss::smoothness(random_array<double>({1, 1, 3}, 11), random_array<double>({1, 1}, 12)) == 0.0);
  CHECK(loss::atlas_smoothness(random_array<double>({1, 3}, 11), random_array<double>({1, 1}, 12)) == 0.0);
}

TEST_CASE("smoothness names both shapes when an argument does not fit", "[loss][smoothness]") {
  auto render = random_array<double>({4, 4, 3}, 6);
  const auto mask = random_array<double>({4, 5}, 7);
  CHECK_THROWS_AS(loss::smoothness(render, mask), ShapeError);
  CHECK_THROWS_WITH(loss::smoothness(render, mask), "smoothness: mask is [4, 5], expected [4, 4]");
  CHECK_THROWS_AS(loss::smoothness_adjoint(render, mask, 1.0, render), ShapeError);
  auto texels = random_array<double>({16, 3}, 8);
  CHECK_THROWS_WITH(loss::atlas_smoothness(texels, mask),
                    "atlas_smoothness: texels is [16, 3], expected [20, 3]");
  CHECK_THROWS_AS(loss::atlas_smoothness_adjoint(texels, mask, 1.0, texels), ShapeError);
}

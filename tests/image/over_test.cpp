#include <tapestry/image/over.hpp>

#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"

using namespace tapestry;
using namespace tapestry::test;

TEST_CASE("over equals a pixel worked out by hand, and leaves what lies beside it", "[image][over]") {
  const Array<double, 3> front = {{{1.0, 0.5}}};
  const Array<double, 2> coverage = {{0.25}};
  const Array<double, 3> background = {{{7.0, 8.0}, {9.0, 10.0}}, {{11.0, 12.0}, {0.0, 4.0}}};
  const Array<double, 3> expected = {{{7.0, 8.0}, {9.0, 10.0}}, {{11.0, 12.0}, {1.0, 3.5}}};
  CHECK((image::over(front, coverage, background, 1, 1) == expected));
}

TEST_CASE("full coverage hides the background and passes it no gradient", "[image][over]") {
  const auto front = random_array<float>({4, 5, 3}, 1);
  const auto background = random_array<float>({4, 5, 3}, 2);
  const auto coverage = tapestry::filled<float, 2>({4, 5}, 1);
  CHECK((image::over(front, coverage, background) == front));
  Array<float, 3> background_adjoint = xt::zeros_like(background);
  image::over_adjoint<float>(front, coverage, background, random_array<float>({4, 5, 3}, 3), nullptr, nullptr,
                             &background_adjoint);
  CHECK((background_adjoint == tapestry::zeros<float, 3>({4, 5, 3})));
}

TEMPLATE_TEST_CASE("over_adjoint agrees with central differences", "[image][gradient]", float, double) {
  const auto front = random_array<TestType>({4, 5, 3}, 1);
  const auto mask = random_array<TestType>({4, 5}, 2);
  const auto background = random_array<TestType>({7, 8, 3}, 3);
  const auto weights = random_direction<TestType>({7, 8, 3}, 4);
  Array<TestType, 3> front_adjoint = xt::zeros_like(front), background_adjoint = xt::zeros_like(background);
  Array<TestType, 2> mask_adjoint = xt::zeros_like(mask);
  for (const TestType half : {TestType(0.5), TestType(0.5)})  // make a whole only if the adjoint adds
    image::over_adjoint<TestType>(front, mask, background, half * weights, &front_adjoint, &mask_adjoint,
                                  &background_adjoint, 2, 1);

  const auto of_front = [&](const auto& x) { return dot(weights, image::over(x, mask, background, 2, 1)); };
  const auto of_mask = [&](const auto& x) { return dot(weights, image::over(front, x, background, 2, 1)); };
  const auto of_background = [&](const auto& x) { return dot(weights, image::over(front, mask, x, 2, 1)); };
  const auto front_direction = random_direction<TestType>({4, 5, 3}, 5);
  const auto picture_direction = random_direction<TestType>({7, 8, 3}, 7);
  const auto mask_direction = random_direction<TestType>({4, 5}, 6);
  const TestType tolerance = central_difference_tolerance(of_front(front));
  CHECK(std::abs(dot(front_adjoint, front_direction) -
                 central_difference(of_front, front, front_direction)) <= tolerance);
  CHECK(std::abs(dot(mask_adjoint, mask_direction) - central_difference(of_mask, mask, mask_direction)) <=
        tolerance);
  CHECK(std::abs(dot(background_adjoint, picture_direction) -
                 central_difference(of_background, background, picture_direction)) <= tolerance);
}

TEST_CASE("over names what does not fit", "[image][over]") {
  const auto front = random_array<double>({4, 4, 3}, 1);
  const auto background = random_array<double>({6, 6, 3}, 2);
  CHECK_THROWS_WITH(image::over(front, random_array<double>({4, 5}, 3), background),
                    "over: premultiplied is [4, 4, 3], expected [4, 5, 3]");
  CHECK_THROWS_WITH(image::over(front, random_array<double>({4, 4}, 3), background, 3, 0),
                    "over: the window of 4x4 pixels at row 3, column 0 leaves the picture, [6, 6]");
}

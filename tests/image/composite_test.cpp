#include <cmath>
#include <tapestry/image/composite.hpp>

#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"

namespace image = tapestry::image;
using tapestry::Array;
using tapestry::test::central_difference;
using tapestry::test::central_difference_tolerance;
using tapestry::test::dot;
using tapestry::test::random_array;
using tapestry::test::random_direction;

TEST_CASE("composite and over equal a pixel worked out by hand", "[image][composite]") {
  const Array<double, 3> render = {{{1.0, 0.5}}};
  const Array<double, 2> mask = {{0.25}};
  const Array<double, 3> background = {{{0.0, 4.0}}};
  const auto mixed = image::composite(render, mask, background);
  CHECK(mixed(0, 0, 0) == 0.25);
  CHECK(mixed(0, 0, 1) == 3.125);
  const auto laid = image::over(render, mask, background);
  CHECK(laid(0, 0, 0) == 1.0);
  CHECK(laid(0, 0, 1) == 3.5);
}

TEST_CASE("an all-zero mask leaves the background and passes no gradient to the render",
          "[image][composite]") {
  const auto render = random_array<float>({4, 5, 3}, 1);
  const auto background = random_array<float>({4, 5, 3}, 2);
  const auto mask = tapestry::zeros<float, 2>({4, 5});
  CHECK((image::composite(render, mask, background) == background));
  Array<float, 3> render_adjoint = xt::zeros_like(render);
  image::composite_adjoint<float>(render, mask, background, random_array<float>({4, 5, 3}, 3),
                                  &render_adjoint, nullptr, nullptr);
  CHECK((render_adjoint == tapestry::zeros<float, 3>({4, 5, 3})));
}

TEMPLATE_TEST_CASE("composite_adjoint agrees with central differences", "[image][gradient]", float, double) {
  const auto render = random_array<TestType>({4, 5, 3}, 1);
  const auto mask = random_array<TestType>({4, 5}, 2);
  const auto background = random_array<TestType>({4, 5, 3}, 3);
  const auto weights = random_direction<TestType>({4, 5, 3}, 4);
  Array<TestType, 3> render_adjoint = xt::zeros_like(render), background_adjoint = xt::zeros_like(render);
  Array<TestType, 2> mask_adjoint = xt::zeros_like(mask);
  image::composite_adjoint(render, mask, background, weights, &render_adjoint, &mask_adjoint,
                           &background_adjoint);

  const auto of_render = [&](const auto& x) { return dot(weights, image::composite(x, mask, background)); };
  const auto of_mask = [&](const auto& x) { return dot(weights, image::composite(render, x, background)); };
  const auto of_background = [&](const auto& x) { return dot(weights, image::composite(render, mask, x)); };
  const auto picture_direction = random_direction<TestType>({4, 5, 3}, 5);
  const auto mask_direction = random_direction<TestType>({4, 5}, 6);
  const TestType tolerance = central_difference_tolerance(of_render(render));
  CHECK(std::abs(dot(render_adjoint, picture_direction) -
                 central_difference(of_render, render, picture_direction)) <= tolerance);
  CHECK(std::abs(dot(mask_adjoint, mask_direction) - central_difference(of_mask, mask, mask_direction)) <=
        tolerance);
  CHECK(std::abs(dot(background_adjoint, picture_direction) -
                 central_difference(of_background, background, picture_direction)) <= tolerance);
}

TEMPLATE_TEST_CASE("over_adjoint agrees with central differences", "[image][gradient]", float, double) {
  const auto front = random_array<TestType>({4, 5, 3}, 1);
  const auto mask = random_array<TestType>({4, 5}, 2);
  const auto background = random_array<TestType>({4, 5, 3}, 3);
  const auto weights = random_direction<TestType>({4, 5, 3}, 4);
  Array<TestType, 3> front_adjoint = xt::zeros_like(front), background_adjoint = xt::zeros_like(front);
  Array<TestType, 2> mask_adjoint = xt::zeros_like(mask);
  image::over_adjoint(mask, background, weights, &front_adjoint, &mask_adjoint, &background_adjoint);

  const auto of_front = [&](const auto& x) { return dot(weights, image::over(x, mask, background)); };
  const auto of_mask = [&](const auto& x) { return dot(weights, image::over(front, x, background)); };
  const auto of_background = [&](const auto& x) { return dot(weights, image::over(front, mask, x)); };
  const auto picture_direction = random_direction<TestType>({4, 5, 3}, 5);
  const auto mask_direction = random_direction<TestType>({4, 5}, 6);
  const TestType tolerance = central_difference_tolerance(of_front(front));
  CHECK(std::abs(dot(front_adjoint, picture_direction) -
                 central_difference(of_front, front, picture_direction)) <= tolerance);
  CHECK(std::abs(dot(mask_adjoint, mask_direction) - central_difference(of_mask, mask, mask_direction)) <=
        tolerance);
  CHECK(std::abs(dot(background_adjoint, picture_direction) -
                 central_difference(of_background, background, picture_direction)) <= tolerance);
}

TEST_CASE("composite names both shapes when a mask does not fit", "[image][composite]") {
  const auto render = random_array<double>({4, 4, 3}, 1);
  const auto mask = random_array<double>({4, 5}, 2);
  CHECK_THROWS_WITH(image::composite(render, mask, render), "composite: mask is [4, 5], expected [4, 4]");
  CHECK_THROWS_AS(image::over(render, mask, render), tapestry::ShapeError);
}

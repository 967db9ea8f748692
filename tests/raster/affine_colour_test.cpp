#include <cmath>
#include <tapestry/raster/affine_colour.hpp>

#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"

namespace raster = tapestry::raster;
using tapestry::test::dot;
using tapestry::test::random_array;

TEST_CASE("affine colour leaves what is not covered empty", "[raster][affine_colour]") {
  const auto map = raster::uniform_affine_colour<double>(1, 2, {2, 1, 0.5}, {0.1, 0, -0.1});
  const tapestry::Array<double, 3> image = {{{0.2, 0.4, 0.6}, {0, 0, 0}}};
  const tapestry::Array<double, 2> coverage = {{0.5, 0}};
  const auto found = raster::affine_colour(image, coverage, map);
  CHECK(found(0, 0, 0) == Approx(0.45));
  CHECK(found(0, 0, 1) == Approx(0.4));
  CHECK(found(0, 0, 2) == Approx(0.25));
  for (std::size_t c = 0; c < 3; ++c) CHECK(found(0, 1, c) == 0);
}

TEMPLATE_TEST_CASE("affine_colour's adjoints agree with central differences", "[raster][gradient]", float,
                   double) {
  using T = TestType;
  const auto image = random_array<T>({5, 4, 3}, 1);
  const auto coverage = random_array<T>({5, 4}, 2);
  const raster::AffineColour<T> map{random_array<T>({5, 4, 3}, 3), random_array<T>({5, 4, 3}, 4)};
  const auto weights = tapestry::test::random_direction<T>({5, 4, 3}, 5);
  const auto direction = tapestry::test::random_direction<T>({5, 4, 3}, 6);
  raster::AffineColour<T> map_adjoint{tapestry::zeros<T, 3>({5, 4, 3}), tapestry::zeros<T, 3>({5, 4, 3})};
  auto image_adjoint = tapestry::zeros<T, 3>({5, 4, 3});
  raster::affine_colour_adjoint(map, weights, image_adjoint);
  raster::affine_colour_map_adjoint(image, coverage, weights, map_adjoint);
  const auto check = [&](const auto& gradient, const auto& at, auto value) {
    CHECK(std::abs(dot(gradient, direction) - tapestry::test::central_difference(value, at, direction)) <=
          tapestry::test::central_difference_tolerance(value(at)));
  };
  check(image_adjoint, image,
        [&](const auto& x) { return dot(weights, raster::affine_colour(x, coverage, map)); });
  check(map_adjoint.gain, map.gain, [&](const auto& gain) {
    return dot(weights, raster::affine_colour(image, coverage, raster::AffineColour<T>{gain, map.bias}));
  });
  check(map_adjoint.bias, map.bias, [&](const auto& bias) {
    return dot(weights, raster::affine_colour(image, coverage, raster::AffineColour<T>{map.gain, bias}));
  });
}

TEST_CASE("affine_colour refuses maps of another size", "[raster][affine_colour]") {
  const auto map = raster::uniform_affine_colour<float>(3, 4, {1, 1, 1}, {0, 0, 0});
  const auto image = tapestry::zeros<float, 3>({3, 5, 3});
  CHECK_THROWS_WITH(raster::affine_colour(image, tapestry::zeros<float, 2>({3, 5}), map),
                    "affine_colour: gain is [3, 4, 3], expected [3, 5, 3]");
  CHECK_THROWS_AS(raster::affine_colour(image, tapestry::zeros<float, 2>({3, 4}), map), tapestry::ShapeError);
}

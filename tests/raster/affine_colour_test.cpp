#include <tapestry/raster/affine_colour.hpp>

#include <cmath>
#include <tapestry/autodiff/array_functions.hpp>
#include <tapestry/autodiff/tape.hpp>

#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"

namespace raster = tapestry::raster;
using tapestry::Array;
using tapestry::ArrayVariable;
using tapestry::test::dot;
using tapestry::test::random_array;

TEST_CASE("affine colour leaves what is not covered empty", "[raster][affine_colour]") {
  const Array<double, 1> gain = {2, 1, 0.5}, bias = {0.1, 0, -0.1};
  const Array<double, 3> image = {{{0.2, 0.4, 0.6}, {0, 0, 0}}};
  const Array<double, 2> coverage = {{0.5, 0}};
  const auto found = raster::affine_colour(image, coverage, gain, bias);
  CHECK(found(0, 0, 0) == Approx(0.45));
  CHECK(found(0, 0, 1) == Approx(0.4));
  CHECK(found(0, 0, 2) == Approx(0.25));
  for (std::size_t c = 0; c < 3; ++c) CHECK(found(0, 1, c) == 0);
}

namespace {
/// All derivatives on the tape, of two records in one sweep, beside central differences.
template <class T, std::size_t Rank>
void check(const Array<T, Rank>& gain, const Array<T, Rank>& bias) {
  const auto image = random_array<T>({5, 4, 3}, 1);
  const auto coverage = random_array<T>({5, 4}, 2);
  const auto weights = tapestry::test::random_direction<T>({5, 4, 3}, 5);
  tapestry::Tape<T> tape;
  const auto scope = tape.activate();
  const auto i = tape.input(image);
  const auto c = tape.input(coverage);
  const auto g = tape.input(gain), b = tape.input(bias);
  const ArrayVariable<T, 3> halves(Array<T, 3>(weights / 2));
  tape.reverse(tapestry::sum(raster::affine_colour(i, c, g, b) * halves) +
               tapestry::sum(raster::affine_colour(i, c, g, b) * halves));
  const auto compare = [&](const auto& input, auto value) {
    auto direction = input.value();
    for (std::size_t k = 0; k < direction.size(); ++k)
      direction.data()[k] = static_cast<T>(std::sin(static_cast<double>(k))) / 8;
    CHECK(std::abs(dot(input.adjoint(), direction) -
                   tapestry::test::central_difference(value, input.value(), direction)) <=
          tapestry::test::central_difference_tolerance(value(input.value())));
  };
  compare(i, [&](const auto& x) { return dot(weights, raster::affine_colour(x, coverage, gain, bias)); });
  compare(c, [&](const auto& x) { return dot(weights, raster::affine_colour(image, x, gain, bias)); });
  compare(g, [&](const auto& x) { return dot(weights, raster::affine_colour(image, coverage, x, bias)); });
  compare(b, [&](const auto& x) { return dot(weights, raster::affine_colour(image, coverage, gain, x)); });
}
}  // namespace

TEMPLATE_TEST_CASE("affine_colour's derivatives agree with central differences", "[raster][gradient]", float,
                   double) {
  check(random_array<TestType>({5, 4, 3}, 3), random_array<TestType>({5, 4, 3}, 4));
  check(random_array<TestType>({3}, 3), random_array<TestType>({3}, 4));
}

TEST_CASE("affine colour of passive arrays records nothing", "[raster][variable]") {
  tapestry::Tape<double> tape;
  const auto scope = tape.activate();
  const ArrayVariable<double, 1> three(tapestry::filled<double, 1>({3}, 1));
  const ArrayVariable<double, 3> image(random_array<double>({2, 2, 3}, 1));
  const ArrayVariable<double, 2> coverage(random_array<double>({2, 2}, 1));
  CHECK(!raster::affine_colour(image, coverage, three, three).is_active());
  CHECK(tape.record_count() == 0);
}

TEST_CASE("affine_colour refuses maps of another size", "[raster][affine_colour]") {
  const auto map = tapestry::zeros<float, 3>({3, 4, 3});
  const auto image = tapestry::zeros<float, 3>({3, 5, 3});
  CHECK_THROWS_WITH(raster::affine_colour(image, tapestry::zeros<float, 2>({3, 5}), map, map),
                    "affine_colour: gain is [3, 4, 3], expected [3, 5, 3]");
  const auto four = tapestry::zeros<float, 1>({4});
  CHECK_THROWS_WITH(raster::affine_colour(image, tapestry::zeros<float, 2>({3, 5}), four, four),
                    "affine_colour: gain is [4], expected [3]");
  CHECK_THROWS_AS(raster::affine_colour(image, tapestry::zeros<float, 2>({3, 4}), map, map),
                  tapestry::ShapeError);
}

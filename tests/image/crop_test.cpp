#include <tapestry/image/crop.hpp>
#include <tapestry/image/letterbox.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"

using namespace tapestry;
using namespace tapestry::test;

TEST_CASE("crop takes the rows and columns of its window", "[image][crop]") {
  const Array<double, 3> picture = {{{1}, {2}, {3}}, {{4}, {5}, {6}}, {{7}, {8}, {9}}};
  const Array<double, 3> part = {{{5}, {6}}, {{8}, {9}}};
  CHECK((image::crop(picture, {1, 1, 2, 2}) == part));
  CHECK((image::crop(picture, {0, 0, 3, 3}) == picture));
  CHECK(image::crop(picture, {3, 3, 0, 0}).size() == 0);
}

TEST_CASE("crop on the tape gives the same, and puts adjoints back in their place",
          "[image][crop][gradient]") {
  ActiveTape<double> tape;
  const auto picture = tape.input(random_array<double>({6, 5, 3}, 1));
  const image::PixelWindow window{2, 1, 3, 2};
  const ArrayVariable<double, 3> part = image::crop(picture, window);
  CHECK((part.value() == image::crop(picture.value(), window)));
  const auto seed = random_array<double>({3, 2, 3}, 2);
  tape.reverse(part, seed);
  CHECK((image::crop(picture.adjoint(), window) == seed));
  CHECK(std::abs(xt::sum(picture.adjoint())() - xt::sum(seed)()) <= 1e-14);
}

TEST_CASE("letterboxed on the tape: its pullback is its transpose", "[image][letterbox][gradient]") {
  const auto x0 = random_array<double>({5, 4, 3}, 1, -1, 1);
  ActiveTape<double> tape;
  const auto x = tape.input(x0);
  const auto y = image::letterboxed(x, 9, 12, 0.0);
  CHECK((y.value() == image::letterboxed(x0, 9, 12, 0.0)));
  const auto g = random_array<double>({9, 12, 3}, 2, -1, 1);
  tape.reverse(y, g);
  CHECK(std::abs(test::dot(x.adjoint(), x0) - test::dot(g, y.value())) <= 1e-13);
}

TEST_CASE("a window that leaves the picture is refused, also where sums would overflow", "[image][crop]") {
  const auto picture = random_array<double>({4, 4, 3}, 1);
  const auto most = std::size_t(-1);
  CHECK_THROWS_WITH(image::crop(picture, {1, 0, 4, 4}),
                    "crop: the window of 4x4 pixels at row 1, column 0 leaves the picture, [4, 4]");
  CHECK_THROWS_AS(image::crop(picture, {most, 0, 2, 1}), ShapeError);
  CHECK_THROWS_AS(image::crop(picture, {2, 0, most, 1}), ShapeError);
}

#include <tapestry/image/batch.hpp>
#include <tapestry/image/over.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"

using namespace tapestry;
using namespace tapestry::test;
using image::ColourSpace;

namespace {
template <class T, std::size_t Rank>
Array<T, Rank> moved(Array<T, Rank> values, T least, T most) {  // from -1 ... 1
  for (std::size_t i = 0; i < values.size(); ++i)
    values.data()[i] = least + (most - least) * (values.data()[i] + 1) / 2;
  return values;
}
}  // namespace

TEST_CASE("the curve of sRGB goes through the values of its standard", "[image][colour_space]") {
  // IEC 61966-2-1: bytes and the light that they stand for, by the formula in ten digits.
  CHECK(image::linearised(0.0) == 0);
  CHECK(image::linearised(1.0) == Approx(1).epsilon(1e-15));
  CHECK(image::linearised(10.0 / 255) == Approx(0.0030352698).epsilon(1e-7));
  CHECK(image::linearised(11.0 / 255) == Approx(0.0033465358).epsilon(1e-7));
  CHECK(image::linearised(128.0 / 255) == Approx(0.2158605001).epsilon(1e-9));
  CHECK(image::encoded(0.5) == Approx(0.7353569831).epsilon(1e-9));
  CHECK(image::encoded(0.5F) == Approx(0.7353570F).epsilon(1e-6));
}

TEST_CASE("encoded inverts linearised, also beyond black and white", "[image][colour_space]") {
  for (double value = -0.5; value <= 3; value += 1.0 / 1024)
    CHECK(image::encoded(image::linearised(value)) == Approx(value).margin(1e-14).epsilon(0));
  for (int byte = 0; byte < 256; ++byte) {
    const float value = static_cast<float>(byte) / 255;
    CHECK(image::encoded(image::linearised(value)) == Approx(value).margin(2e-7).epsilon(0));
  }
}

TEST_CASE("the curve's line and its power meet without a step", "[image][colour_space]") {
  const double encoded = 0.0404482362771081917, linear = encoded / 12.92, step = 1e-15;
  CHECK(image::linearised(encoded + step) ==
        Approx(image::linearised(encoded - step)).margin(1e-15).epsilon(0));
  CHECK(image::encoded(linear + step) == Approx(image::encoded(linear - step)).margin(1e-13).epsilon(0));
}

TEST_CASE("light of float colours by vectors has the error that it states", "[image][colour_space]") {
  Array<float, 2> colours(Extents<2>{70000, 3});
  for (std::size_t i = 0; i < colours.size(); ++i) colours.data()[i] = -0.1F + 1e-5F * static_cast<float>(i);
  const auto light = image::linearised(colours);
  double worst = 0;
  for (std::size_t i = 0; i < colours.size(); ++i) {
    const auto x = static_cast<double>(colours.data()[i]), found = static_cast<double>(light.data()[i]);
    if (x != 0) worst = std::max(worst, std::abs(found / image::linearised(x) - 1));
  }
  CHECK(worst <= 6e-7);
  const float infinity = std::numeric_limits<float>::infinity();
  const auto ends = image::linearised(Array<float, 1>{infinity, -infinity, std::nanf(""), 0.0F});
  CHECK(ends(0) == infinity);
  CHECK(ends(1) == -infinity);
  CHECK(std::isnan(ends(2)));
  CHECK(ends(3) == 0);
}

TEST_CASE("not a number stays one, and infinite light stays so", "[image][colour_space]") {
  const double nan = std::numeric_limits<double>::quiet_NaN(),
               infinity = std::numeric_limits<double>::infinity();
  CHECK(std::isnan(image::linearised(nan)));
  CHECK(std::isnan(image::encoded(nan)));
  CHECK(image::encoded(image::linearised(infinity)) == infinity);
  CHECK(image::encoded(image::linearised(-infinity)) == -infinity);
}

TEST_CASE("both curves' slopes on the tape agree with central differences",
          "[image][colour_space][gradient]") {
  const auto check = [](const auto& curve, double least, double most) {
    const auto x = moved(random_array<double>({50, 3}, 1), least, most);
    const auto weights = random_direction<double>({50, 3}, 2);
    ActiveTape<double> tape;
    const auto input = tape.input(x);
    tape.reverse(curve(input), weights);
    const auto direction = random_direction<double>({50, 3}, 3);
    const double difference =
        central_difference([&](const auto& at) { return dot(weights, curve(at)); }, x, direction);
    CHECK(dot(input.adjoint(), direction) == Approx(difference).epsilon(1e-6));
  };
  const auto linearise = [](const auto& x) { return image::linearised(x); };
  const auto encode = [](const auto& x) { return image::encoded(x); };
  check(linearise, 0.05, 1.2);
  check(linearise, -0.2, 0.04);
  check(encode, 0.01, 1.2);
  check(encode, -0.1, 0.003);
}

TEST_CASE("half black and half white give a camera's grey in light and another by numbers", "[image][over]") {
  const Array<double, 3> white = {{{0.5}}}, black = {{{0.0}}};
  const Array<double, 2> half = {{0.5}};
  CHECK(image::over(white, half, black, 0, 0, ColourSpace::linear)(0, 0, 0) ==
        Approx(0.7353569831).epsilon(1e-9));
  CHECK(image::over(white, half, black)(0, 0, 0) == 0.5);
}

TEST_CASE("in light the background keeps its bits where nothing covers it", "[image][over]") {
  const auto background = moved(random_array<float>({9, 8, 3}, 1), 0.F, 1.F);
  const auto nothing = tapestry::zeros<float, 3>({5, 4, 3});
  const auto none = tapestry::zeros<float, 2>({5, 4});
  CHECK((image::over(nothing, none, background, 2, 3, ColourSpace::linear) == background));
}

TEST_CASE("full coverage hides even a background that is not a number", "[image][over]") {
  const Array<double, 3> front = {{{0.25}}}, background = {{{std::numeric_limits<double>::quiet_NaN()}}};
  const Array<double, 2> full = {{1.0}};
  CHECK(image::over(front, full, background, 0, 0, ColourSpace::linear)(0, 0, 0) == image::encoded(0.25));
}

TEST_CASE("over in light has the adjoints of central differences by all its arguments",
          "[image][over][gradient]") {
  const auto front = moved(random_array<double>({4, 5, 3}, 1), 0.05, 0.9);
  const auto mask = moved(random_array<double>({4, 5}, 2), 0.05, 0.95);
  const auto background = moved(random_array<double>({7, 8, 3}, 3), 0.1, 0.95);
  const auto weights = random_direction<double>({7, 8, 3}, 4);
  ActiveTape<double> tape;
  const auto p = tape.input(front), b = tape.input(background);
  const auto c = tape.input(mask);
  tape.reverse(image::over(p, c, b, 2, 1, ColourSpace::linear), weights);
  const auto at = [&](const auto& x, const auto& y, const auto& z) {
    return dot(weights, image::over(x, y, z, 2, 1, ColourSpace::linear));
  };
  const auto agrees = [](const auto& adjoint, const auto& function, const auto& x, const auto& direction) {
    CHECK(dot(adjoint, direction) == Approx(central_difference(function, x, direction)).epsilon(1e-6));
  };
  agrees(
      p.adjoint(), [&](const auto& x) { return at(x, mask, background); }, front,
      random_direction<double>({4, 5, 3}, 5));
  agrees(
      c.adjoint(), [&](const auto& x) { return at(front, x, background); }, mask,
      random_direction<double>({4, 5}, 6));
  agrees(
      b.adjoint(), [&](const auto& x) { return at(front, mask, x); }, background,
      random_direction<double>({7, 8, 3}, 7));
}

TEST_CASE("a batch laid over in light equals its pictures, values and adjoints", "[image][over]") {
  const auto front = moved(random_array<double>({3, 4, 3}, 1), 0.0, 0.5);
  const auto mask = moved(random_array<double>({3, 4}, 2), 0.5, 1.0);
  const auto background =
      std::make_shared<const Array<double, 3>>(moved(random_array<double>({6, 7, 3}, 3), 0.0, 1.0));
  const std::vector<image::Backdrop<double>> backdrops(
      2, {background, std::make_shared<const Array<double, 2>>(mask), 1, 2});
  const auto weights = random_direction<double>({2, 6, 7, 3}, 4);
  ActiveTape<double> tape;
  const auto first = tape.input(front), second = tape.input(front);
  const auto batch = image::over(std::vector{first, second}, backdrops, ColourSpace::linear);
  tape.reverse(batch, weights);
  for (std::size_t n = 0; n < 2; ++n) {
    CHECK((image::picture_of(batch.value(), n) ==
           image::over(front, mask, *background, 1, 2, ColourSpace::linear)));
    auto expected = tapestry::zeros<double, 3>(front.shape());
    image::over_adjoint<double>(front, mask, *background, image::picture_of(weights, n), &expected, nullptr,
                                nullptr, 1, 2, ColourSpace::linear);
    CHECK(((n == 0 ? first : second).adjoint() == expected));
  }
}

TEST_CASE("an unknown colour space is refused by name", "[image][colour_space]") {
  CHECK(image::colour_space_by_name("linear") == ColourSpace::linear);
  CHECK_THROWS_WITH(image::colour_space_by_name("gamma"),
                    "no colour space 'gamma'; expected encoded or linear");
}

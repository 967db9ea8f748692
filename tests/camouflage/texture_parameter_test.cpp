#include <tapestry/camouflage/paint.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"

using namespace tapestry;
using namespace tapestry::test;

TEST_CASE("texture_colours is mid grey at zero and stays in [0, 1]", "[camouflage][texture]") {
  Array<double, 2> parameter(Extents<2>{1, 3});
  parameter(0, 0) = 0;
  parameter(0, 1) = 1e6;
  parameter(0, 2) = -1e6;
  const auto colours = camouflage::texture_colours(parameter);
  CHECK(colours(0, 0) == 0.5);
  CHECK(colours(0, 1) == 1.0);
  CHECK(colours(0, 2) == 0.0);
}

namespace {
/// weights · dc/dp by the tape.
template <class T>
Array<T, 2> parameter_adjoint(const Array<T, 2>& parameter, const Array<T, 2>& weights) {
  ActiveTape<T> tape;
  const auto p = tape.input(parameter);
  tape.reverse(camouflage::texture_colours(p), weights);
  return p.adjoint();
}
}  // namespace

TEMPLATE_TEST_CASE("the slope of texture_colours agrees with central differences", "[camouflage][gradient]",
                   float, double) {
  const auto parameter = random_array<TestType>({7, 3}, 1, -3, 3);
  const auto weights = random_array<TestType>({7, 3}, 2);
  const auto direction = test::random_direction<TestType>({7, 3}, 3);
  const auto value = [&](const Array<TestType, 2>& p) {
    return test::dot(camouflage::texture_colours(p), weights);
  };
  CHECK(std::abs(test::dot(parameter_adjoint(parameter, weights), direction) -
                 test::central_difference(value, parameter, direction)) <=
        test::central_difference_tolerance(value(parameter)));
}

TEMPLATE_TEST_CASE("a saturated tanh has a tiny but never a NaN gradient", "[camouflage][texture]", float,
                   double) {
  Array<TestType, 2> parameter(Extents<2>{1, 3});
  parameter(0, 0) = TestType(20);
  parameter(0, 1) = std::numeric_limits<TestType>::max();
  parameter(0, 2) = TestType(-20);
  const auto adjoint = parameter_adjoint(parameter, tapestry::filled<TestType, 2>({1, 3}, TestType(1)));
  // ½ (1 − tanh²) = 2 e^(−40) to within e^(−40) of itself: its relative accuracy survives saturation.
  const auto exact = TestType(2 * std::exp(-40.0));
  CHECK(std::abs(adjoint(0, 0) - exact) <= 100 * std::numeric_limits<TestType>::epsilon() * exact);
  CHECK(adjoint(0, 1) == TestType(0));
  CHECK(adjoint(0, 2) == adjoint(0, 0));
}

TEST_CASE("dark colours keep their digits in float", "[camouflage][texture]") {
  const auto p = random_array<float>({5000, 3}, 5, -40, 5);
  const auto colours = camouflage::texture_colours(p);
  for (std::size_t i = 0; i < p.size(); ++i) {
    const double exact = 1 / (1 + std::exp(-2 * static_cast<double>(p.data()[i])));
    CHECK(std::abs(static_cast<double>(colours.data()[i]) - exact) <= 3e-7 * exact);
  }
}

TEST_CASE("parameter_of_colours is undone by texture_colours, but for white and black",
          "[camouflage][texture]") {
  auto colours = random_array<double>({5, 3}, 4, 0.01, 0.99);
  colours(0, 0) = 1;
  colours(0, 1) = 0;
  const auto parameter = camouflage::parameter_of_colours(colours);
  const auto again = camouflage::texture_colours(parameter);
  CHECK(std::abs(again(0, 0) - (1 - camouflage::colour_margin)) < 1e-12);
  CHECK(std::abs(again(0, 1) - camouflage::colour_margin) < 1e-12);
  for (std::size_t i = 2; i < colours.size(); ++i)
    CHECK(std::abs(again.data()[i] - colours.data()[i]) < 1e-12);
}

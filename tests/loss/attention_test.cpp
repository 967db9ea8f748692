#include <tapestry/loss/attention.hpp>

#include "../support/active_tape.hpp"
#include "../support/catch.hpp"
#include "../support/finite_difference.hpp"
#include "../support/random_array.hpp"

using namespace tapestry;

namespace {
/// A map half of whose places have heat, none of it within a step of 0.
template <class T>
Array<T, 2> some_heat() {
  auto heat = test::random_array<T>({7, 9}, 1, -1, 1);
  for (T& value : heat.storage()) value += value > 0 ? T(0.1) : T(-0.1);
  return heat;
}
}  // namespace

TEST_CASE("attention equals what is worked out by hand", "[loss][attention]") {
  const Array<double, 2> heat = {{0.5, 0.0, 2.0}, {0.5, -1.0, 0.0}};  // parts of two places and of one
  const double left = 2 * std::tanh(0.5) / (7 - 2), right = std::tanh(2.0) / (7 - 1);
  CHECK(loss::attention(heat) == Approx((left + right) / 2).epsilon(1e-15));
  const Array<double, 2> corners = {{1.0, 0.0}, {0.0, 1.0}};  // do not hang together
  CHECK(loss::attention(corners) == Approx(std::tanh(1.0) / (5 - 1)).epsilon(1e-15));
  CHECK(loss::attention(Array<double, 2>{{0.0, -1.0}}) == 0);
  CHECK(loss::attention(Array<double, 2>{{std::nan(""), 0.0}}) == 0);
  const auto everywhere = tapestry::filled<double, 2>({3, 4}, 1e9);
  CHECK(loss::attention(everywhere) == 12);  // one part covers everything
  CHECK(loss::attention(tapestry::zeros<double, 2>({0, 4})) == 0);
}

TEST_CASE("less heat and smaller parts give less attention", "[loss][attention]") {
  const Array<double, 2> whole = {{1.0, 1.0, 1.0, 1.0}}, fainter = {{1.0, 1.0, 1.0, 0.5}};
  const Array<double, 2> parted = {{1.0, 1.0, 0.0, 1.0}};
  CHECK(loss::attention(fainter) < loss::attention(whole));
  CHECK(loss::attention(parted) < loss::attention(whole));
}

TEMPLATE_TEST_CASE("attention_adjoint agrees with central differences", "[loss][attention][gradient]", float,
                   double) {
  const auto heat = some_heat<TestType>();
  const auto direction = test::random_direction<TestType>({7, 9}, 2);
  Array<TestType, 2> gradient = tapestry::zeros<TestType, 2>({7, 9});
  for (int half = 0; half < 2; ++half)  // two halves make a whole only if the adjoint adds
    loss::attention_adjoint(heat, TestType(0.5), gradient);
  const auto value = [](const Array<TestType, 2>& map) { return loss::attention(map); };
  CHECK(std::abs(test::dot(gradient, direction) - test::central_difference(value, heat, direction)) <=
        test::central_difference_tolerance(value(heat)));
  auto other = tapestry::zeros<TestType, 2>({7, 8});
  CHECK_THROWS_WITH(loss::attention_adjoint(heat, TestType(1), other),
                    "attention_adjoint: heat_adjoint is [7, 8], expected [7, 9]");
}

TEST_CASE("attention on the tape is attention, with its adjoint", "[loss][attention]") {
  const auto heat = some_heat<double>();
  test::ActiveTape<double> tape;
  const auto variable = tape.input(heat);
  const auto value = loss::attention(variable);
  CHECK(value.value() == loss::attention(heat));
  tape.reverse(Variable<double>(3.0 * value));
  auto expected = tapestry::zeros<double, 2>({7, 9});
  loss::attention_adjoint(heat, 3.0, expected);
  CHECK((variable.adjoint() == expected));
}

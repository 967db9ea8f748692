#include <tapestry/autodiff/array_variable.hpp>
#include <tapestry/autodiff/variable.hpp>

#include "../support/catch.hpp"
#include "../support/random_array.hpp"

using tapestry::Array, tapestry::ArrayVariable, tapestry::DomainError, tapestry::Tape, tapestry::Variable,
    tapestry::test::random_array;

TEST_CASE("an array is passive until a tape makes it an input", "[autodiff][array_variable]") {
  const auto values = random_array<double>({2, 3}, 1);
  const ArrayVariable<double, 2> frozen = values;
  CHECK_FALSE(frozen.is_active());
  CHECK(frozen.adjoint() == tapestry::zeros<double, 2>({2, 3}));
  Tape<double> tape;
  const auto input = tape.input(values);
  CHECK(input.is_active());
  CHECK(input.value() == values);
  CHECK(input.adjoint() == tapestry::zeros<double, 2>({2, 3}));
  CHECK_FALSE(passive(input).is_active());
  CHECK(&passive(input).value() == &input.value());
}

TEST_CASE("an array root is seeded with an array", "[autodiff][array_variable]") {
  Tape<double> tape;
  const auto x = tape.input(random_array<double>({4}, 1));
  const auto seed = random_array<double>({4}, 2);
  tape.reverse(x, seed);
  CHECK(x.adjoint() == seed);
  tape.reverse(x, seed);
  CHECK(x.adjoint() == seed);
  tape.reverse(Variable<double>(1.0));
  CHECK(x.adjoint() == tapestry::zeros<double, 1>({4}));
  CHECK_THROWS_AS(tape.reverse(x, random_array<double>({5}, 2)), tapestry::ShapeError);
  Tape<double> other;
  CHECK_THROWS_AS(other.reverse(x, seed), DomainError);
}

TEST_CASE("an array variable is stale after clear, rewind and the end of its tape",
          "[autodiff][array_variable]") {
  const auto values = random_array<double>({4}, 1);
  std::optional<Tape<double>> tape(std::in_place);
  const auto kept = tape->input(values);
  const auto position = tape->mark();
  const auto rewound = tape->input(values);
  tape->rewind(position);
  CHECK_THROWS_AS(rewound.adjoint(), DomainError);
  CHECK_THROWS_AS(tape->reverse(rewound, values), DomainError);
  CHECK(kept.adjoint().size() == 4);
  tape->clear();
  CHECK_THROWS_AS(kept.adjoint(), DomainError);
  const auto last = tape->input(values);
  tape.reset();
  CHECK_THROWS_AS(last.adjoint(), DomainError);
  CHECK(last.value() == values);
}

TEST_CASE("a moved-from array variable keeps its value", "[autodiff][array_variable]") {
  Tape<double> tape;
  auto x = tape.input(random_array<double>({4}, 1));
  const auto moved = std::move(x);
  CHECK(x.value() == moved.value());
  tape.reverse(moved, moved.value());
  CHECK(x.adjoint() == moved.value());
  CHECK(ArrayVariable<double, 3>().size() == 0);
}
